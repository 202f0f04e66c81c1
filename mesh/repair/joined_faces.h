// SPDX-License-Identifier: GPL-3.0-or-later
// Joins faces at vertices that have the same position.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "mesh/mesh.h"

namespace lumatlas {

// Returns the mesh's faces, each vertex replaced by the lowest-numbered one at exactly the same position. Faces that a
// model file has cut apart at the borders of cells are neighbours again. Throws std::invalid_argument for a face that
// refers to no vertex.
[[nodiscard]] std::vector<glm::uvec3> joined_faces(const Mesh& mesh);

}  // namespace lumatlas
