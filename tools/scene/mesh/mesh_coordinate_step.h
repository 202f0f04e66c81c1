// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the step of the numbers in a mesh file: how finely they can place a vertex.
#pragma once

#include "mesh/mesh.h"

namespace lumatlas {

// Returns the distance between neighbouring numbers of the file, in its units, along the axis where it is largest: of
// 32-bit numbers 0.5 at 5,000,000, of text with 6 digits 10. Vertices lie up to half of it beside their place. 0 where
// the numbers have more digits than 32 bits hold, or there are no finite ones. Looks at some 100,000 vertices.
[[nodiscard]] double mesh_coordinate_step(const TriangleSoup& soup);

}  // namespace lumatlas
