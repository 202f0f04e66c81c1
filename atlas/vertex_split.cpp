// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/vertex_split.h"

#include <numeric>

namespace lumatlas {

namespace {

constexpr std::uint32_t kNone = ~0u;

// The copies of each vertex, as chains: from the vertex to its first copy, from that to the next.
class Copies {
 public:
  Copies(VertexSplit& split, std::size_t vertices) : split_(split), next_(vertices, kNone), used_(vertices, 0) {
    split_.source.resize(vertices);
    std::iota(split_.source.begin(), split_.source.end(), 0u);
    split_.values.assign(vertices, 0);
  }

  // The copy of a given vertex that has a value.
  std::uint32_t with(std::uint32_t vertex, std::uint32_t value) {
    if (!used_[vertex]) {
      used_[vertex] = 1;
      split_.values[vertex] = value;
      return vertex;
    }
    std::uint32_t copy = vertex;
    while (split_.values[copy] != value && next_[copy] != kNone) copy = next_[copy];
    return split_.values[copy] == value ? copy : append(copy, vertex, value);
  }

 private:
  std::uint32_t append(std::uint32_t last, std::uint32_t vertex, std::uint32_t value) {
    const auto copy = static_cast<std::uint32_t>(split_.source.size());
    split_.source.push_back(vertex);
    split_.values.push_back(value);
    next_.push_back(kNone);
    next_[last] = copy;
    return copy;
  }

  VertexSplit& split_;
  std::vector<std::uint32_t> next_;
  std::vector<std::uint8_t> used_;  // 1: a face has the vertex already
};

}  // namespace

VertexSplit split_vertices(std::span<const glm::uvec3> faces, std::size_t vertices,
                           const std::function<std::uint32_t(std::size_t face, int corner)>& value_of) {
  VertexSplit split;
  split.faces.assign(faces.begin(), faces.end());
  Copies copies(split, vertices);
  for (std::size_t face = 0; face < faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      std::uint32_t& vertex = split.faces[face][corner];
      vertex = copies.with(vertex, value_of(face, corner));
    }
  }
  return split;
}

}  // namespace lumatlas
