// SPDX-License-Identifier: GPL-3.0-or-later
// Which views look through the mesh, by points of structure from motion: those that views have seen and that lie behind
// the mesh there. It costs little and proves nothing; contradicted_faces.h decides.
#pragma once

#include <cstddef>
#include <vector>

#include "mesh/visibility.h"
#include "tools/scene/scene.h"
#include "tools/scene/scene_points.h"

namespace lumatlas {

// Returns those of `ranks`, ascending, whose views have each seen 20 points or more of which all views that saw them,
// three at least, find the mesh clearly before them: by 5 % of the depth, on the pixel and all around it. Those with
// most such points are taken, 100 at most; none if there are fewer than three. Points without views say nothing. Points
// and views are in the frame of the mesh. Throws Interrupted soon after a signal.
[[nodiscard]] std::vector<std::size_t> views_through_mesh(const ScenePoints& points,
                                                          const std::vector<SceneView>& views,
                                                          const std::vector<std::size_t>& ranks,
                                                          const Visibility& visibility);

}  // namespace lumatlas
