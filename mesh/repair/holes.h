// SPDX-License-Identifier: GPL-3.0-or-later
// Closes small holes of a mesh, as depth cameras and reconstructions leave them (CGAL's hole filling).
#pragma once

#include <cstdint>

#include "mesh/cancel_check.h"
#include "mesh/mesh.h"

namespace lumatlas {

struct ClosedHoles {
  Mesh mesh;                // with the same vertices; new faces come last
  std::uint64_t holes = 0;  // how many holes were closed
  std::uint64_t faces = 0;  // how many faces closed them
};

// Closes the holes, which are boundary loops, whose box has a diagonal of at most `largest`, scene units. A loop whose
// diagonal is at least half of that of its component's box counts as the component's rim and stays open. A hole that
// cannot be closed with faces that have an area, and without a third face at an edge, stays. The patch is minimal in
// the largest angle between neighbouring faces, then in area. Up to 250 edges all faces are tried, up to 3000 those of
// a Delaunay triangulation. A hole without such a patch is filled as it is seen along the axis in which it is largest.
// Throws std::invalid_argument unless `largest` is finite and not negative and the mesh passes check(); boundary that
// branches, as no mesh of repair() has it, is left alone. `cancel_check` is called for each hole, and often while one
// is filled.
[[nodiscard]] ClosedHoles close_holes(const Mesh& mesh, double largest, const CancelCheck& cancel_check = {});

}  // namespace lumatlas
