// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes of fewer faces by edge collapses: Lindstrom and Turk, "Fast and memory efficient polygonal simplification",
// 1998, by CGAL.
#pragma once

#include <cstddef>

#include "mesh/mesh.h"

namespace lumatlas {

// Collapses the edge that costs least, one after the other, until `faces` are left. Stops before if every further
// collapse would make the mesh non-manifold or turn a face over. A collapse removes two faces, so one fewer may be
// left. Boundaries keep their course. Colours are dropped. Throws std::invalid_argument if the mesh breaks a rule of
// mesh.h or is not manifold.
[[nodiscard]] Mesh decimated(const Mesh& mesh, std::size_t faces);

}  // namespace lumatlas
