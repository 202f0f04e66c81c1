// SPDX-License-Identifier: GPL-3.0-or-later
// Internal: values of vertices for those that have none, from the nearest that have one.
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "mesh/vertex_faces.h"

namespace lumatlas {

// A value is xyz / w, of a vertex that has one; w is 0 where there is none. Ring by ring outwards, each vertex beside
// those that have a value gets the mean of theirs. What is joined to none stays as it is. `around`: of the same faces.
void spread(std::span<const glm::uvec3> faces, const VertexFaces& around, std::vector<glm::vec4>& values);

}  // namespace lumatlas
