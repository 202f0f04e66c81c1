// SPDX-License-Identifier: GPL-3.0-or-later
// The geometry that a view store belongs to: a mesh and its cells.
#pragma once

#include <glm/vec3.hpp>

#include "mesh/cells.h"
#include "mesh/mesh.h"

namespace lumatlas {

struct Surface {
  Mesh mesh;
  Cells cells;
  glm::dvec3 offset{0.0};  // what was subtracted from the input's coordinates, scene units
};

// Throws std::invalid_argument, naming the first face or table that breaks a rule, unless every corner of a face is a
// vertex, the mesh has a colour for each vertex or none at all, and cell_of_face names an existing cell for each face.
void check(const Surface& surface);

}  // namespace lumatlas
