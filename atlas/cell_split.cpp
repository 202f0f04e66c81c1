// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/cell_split.h"

#include <numeric>

namespace lumatlas {

namespace {

constexpr std::uint32_t kNone = ~0u;

// The copies of each vertex, as chains: from the vertex to its first copy, from that to the next.
class Copies {
 public:
  Copies(CellSplit& split, std::size_t vertices) : split_(split), next_(vertices, kNone), used_(vertices, 0) {
    split_.source.resize(vertices);
    std::iota(split_.source.begin(), split_.source.end(), 0u);
    split_.cell_of_vertex.assign(vertices, 0);
  }

  // The copy of a vertex of the mesh that belongs to a cell.
  std::uint32_t in_cell(std::uint32_t vertex, std::uint32_t cell) {
    if (!used_[vertex]) {
      used_[vertex] = 1;
      split_.cell_of_vertex[vertex] = cell;
      return vertex;
    }
    std::uint32_t copy = vertex;
    while (split_.cell_of_vertex[copy] != cell && next_[copy] != kNone) copy = next_[copy];
    return split_.cell_of_vertex[copy] == cell ? copy : append(copy, vertex, cell);
  }

 private:
  std::uint32_t append(std::uint32_t last, std::uint32_t vertex, std::uint32_t cell) {
    const auto copy = static_cast<std::uint32_t>(split_.source.size());
    split_.source.push_back(vertex);
    split_.cell_of_vertex.push_back(cell);
    next_.push_back(kNone);
    next_[last] = copy;
    return copy;
  }

  CellSplit& split_;
  std::vector<std::uint32_t> next_;
  std::vector<std::uint8_t> used_;  // whether a face has the vertex yet
};

}  // namespace

CellSplit split_at_cells(const Mesh& mesh, std::span<const std::uint32_t> cell_of_face) {
  CellSplit split;
  split.faces = mesh.faces;
  Copies copies(split, mesh.positions.size());
  for (std::size_t face = 0; face < split.faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      std::uint32_t& vertex = split.faces[face][corner];
      vertex = copies.in_cell(vertex, cell_of_face[face]);
    }
  }
  return split;
}

}  // namespace lumatlas
