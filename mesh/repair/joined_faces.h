// SPDX-License-Identifier: GPL-3.0-or-later
// Faces whose vertices are told apart by their places alone.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "mesh/mesh.h"

namespace lumatlas {

// The mesh's faces, each vertex replaced by the lowest-numbered one at the very same place: where a mesh is cut, as a
// model file's is at the borders of cells, they meet again. Throws std::invalid_argument for a face that refers to no
// vertex.
[[nodiscard]] std::vector<glm::uvec3> joined_faces(const Mesh& mesh);

}  // namespace lumatlas
