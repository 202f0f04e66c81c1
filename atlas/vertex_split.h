// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: a mesh whose vertices each have one value of what its faces' corners differ in, such as the cell
// or the place in a texture, so that it is an attribute of the vertex.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace lumatlas {

struct VertexSplit {
  std::vector<glm::uvec3> faces;      // in their order, with the numbers of split vertices
  std::vector<std::uint32_t> source;  // for each split vertex, the given vertex that it copies
  std::vector<std::uint32_t> values;  // one per split vertex; 0 if no face has it
};

// The given vertices come first, each with the value of the first corner that has it; its copies with other values
// follow. What is split already stays as it is. `value_of` is asked once for each corner, in order.
[[nodiscard]] VertexSplit split_vertices(std::span<const glm::uvec3> faces, std::size_t vertices,
                                         const std::function<std::uint32_t(std::size_t face, int corner)>& value_of);

}  // namespace lumatlas
