// SPDX-License-Identifier: GPL-3.0-or-later
// Faces of another mesh that photographs show before a mesh: the half of an ear that its reconstruction lacks, behind
// which it has a wall.
//
// Two kinds of evidence must agree, as for contradicted_faces.h. First, depths: where photographs measure something at
// the faces, most of it lies clearly before the mesh, and photographs from different directions do. Second, colours:
// the photographs show the same where the faces are, and something else where the mesh is behind them. Depths alone are
// no proof, because matching makes what stands in front wider than it is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "mesh/mesh.h"
#include "tools/meshing/measured_views.h"

namespace lumatlas {

struct FacesBefore {
  std::vector<std::uint32_t> faces;  // of the other mesh, ascending
  std::size_t groups = 0;            // connected groups of these faces
};

// Returns the faces of `other` that stand before `mesh`. `views` are in the frame of both. A group of faces counts only
// if three views from directions 4 degrees apart measure eight pixels of it or more. `progress` is called after each
// view; what it throws ends the work.
[[nodiscard]] FacesBefore faces_before(const Mesh& mesh, const Mesh& other, std::span<const MeasuredView> views,
                                       const std::function<void()>& progress);

}  // namespace lumatlas
