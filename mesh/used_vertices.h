// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers those vertices of a mesh anew that some of its faces use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mesh/base/id.h"
#include "mesh/mesh.h"

namespace lumatlas {

// Gives numbers in the order in which vertices are first asked for.
class UsedVertices {
 public:
  // `vertices`: how many the mesh has. `first`: the first number that is given.
  explicit UsedVertices(std::size_t vertices, std::size_t first = 0)
      : numbers_(vertices), next_(static_cast<std::uint32_t>(first)) {}

  // Returns the number of a vertex, which is below `vertices`. Where it gets its number now, calls add(), which adds it
  // to the new mesh.
  template <typename Add>
  [[nodiscard]] std::uint32_t number_of(std::uint32_t vertex, const Add& add) {
    VertexId& number = numbers_[vertex];
    if (number == VertexId::none) {
      number = next_;
      ++next_;
      add();
    }
    return number;
  }

 private:
  std::vector<VertexId> numbers_;
  VertexId next_;
};

// Adds faces of a mesh to another one, with the positions that they use and without colours. `kept` returns for the
// index of a face whether it is added.
template <typename Kept>
void add_faces(const Mesh& from, const Kept& kept, Mesh& to) {
  UsedVertices used(from.positions.size(), to.positions.size());
  for (std::size_t i = 0; i < from.faces.size(); ++i) {
    if (!kept(i)) continue;
    glm::uvec3 face = from.faces[i];
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = face[corner];
      face[corner] = used.number_of(vertex, [&] { to.positions.push_back(from.positions[vertex]); });
    }
    to.faces.push_back(face);
  }
}

}  // namespace lumatlas
