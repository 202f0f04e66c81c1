// SPDX-License-Identifier: GPL-3.0-or-later
// Finds views that look through the mesh: they have seen points of structure from motion that lie behind it. The search
// costs little and proves nothing; contradicted_faces.h decides.
#pragma once

#include <cstddef>
#include <vector>

#include "mesh/visibility/visibility.h"
#include "tools/scene/scene.h"
#include "tools/scene/scene_points.h"

namespace lumatlas {

// Returns the ranks, ascending, of views that have each seen 20 points or more behind the mesh. A point is behind the
// mesh if three views or more saw it, and in each of them the mesh is nearer by 5 % of the depth, on the point's pixel
// and all around it. Returns the 100 views with the most such points at most, and none if there are fewer than three.
// Points without views say nothing. Only the views of `ranks` are looked through. Points and views are in the frame of
// the mesh. Throws Interrupted soon after a signal.
[[nodiscard]] std::vector<std::size_t> views_through_mesh(const ScenePoints& points,
                                                          const std::vector<SceneView>& views,
                                                          const std::vector<std::size_t>& ranks,
                                                          const Visibility& visibility);

}  // namespace lumatlas
