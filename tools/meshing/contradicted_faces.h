// SPDX-License-Identifier: GPL-3.0-or-later
// Faces of a mesh where photographs see through it: a lid over a doorway, scraps that float before a wall.
//
// Two kinds of evidence must agree. First, depths: photographs from different directions measure a surface clearly
// behind most of what they see of the faces, and next to none measures the faces themselves. Second, colours: the
// photographs show the same where the measured surface is, and something else where the faces are. Depths alone are no
// proof, because matching misses what is thinner than its patches and measures the wall behind a pole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "mesh/mesh.h"
#include "tools/meshing/measured_views.h"

namespace lumatlas {

struct ContradictedFaces {
  std::vector<std::uint32_t> faces;  // ascending
  std::size_t groups = 0;            // connected groups of these faces
  double pixels = 0;                 // share of the pixels that see the mesh which see these faces, [0, 1]
};

inline constexpr double kMostContradicted = 0.1;  // ContradictedFaces::pixels above which the mesh itself does not fit

// Returns the contradicted faces. `views` are in the frame of the mesh. A group of faces goes only if three views from
// directions 4 degrees apart see eight pixels of it or more. `progress` is called after each view; what it throws ends
// the work.
[[nodiscard]] ContradictedFaces contradicted_faces(const Mesh& mesh, std::span<const MeasuredView> views,
                                                   const std::function<void()>& progress);

}  // namespace lumatlas
