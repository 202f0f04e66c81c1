// SPDX-License-Identifier: GPL-3.0-or-later
// Internal: values of vertices for those that have none, from the nearest that have one.
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "mesh/vertex_faces.h"

namespace lumatlas {

// Spreads values over vertices without one. A value is xyz / w; w is 0 for a vertex without one. Ring by ring outwards,
// each vertex beside vertices with a value gets the mean of theirs. Vertices that are connected to none stay as they
// are. `around` belongs to the same faces.
void spread(std::span<const glm::uvec3> faces, const VertexFaces& around, std::vector<glm::vec4>& values);

}  // namespace lumatlas
