// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/small_pieces.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace lumatlas {
namespace {

// Faces that hang together over vertices have the same number, that of their least vertex.
std::vector<std::uint32_t> pieces_of(const TriangleSoup& soup) {
  std::vector<std::uint32_t> root(soup.positions.size());
  std::iota(root.begin(), root.end(), 0U);
  const auto find = [&](std::uint32_t vertex) {
    while (root[vertex] != vertex) vertex = root[vertex] = root[root[vertex]];
    return vertex;
  };
  for (const glm::uvec3& face : soup.faces) {
    for (int corner = 1; corner < 3; ++corner) {
      const auto [low, high] = std::minmax({find(face[0]), find(face[corner])});
      root[high] = low;
    }
  }
  for (std::uint32_t vertex = 0; vertex < root.size(); ++vertex) root[vertex] = find(vertex);
  return root;
}

}  // namespace

RemovedPieces remove_small_pieces(TriangleSoup& soup, std::size_t fewest_faces) {
  const std::vector<std::uint32_t> piece = pieces_of(soup);
  std::vector<std::size_t> faces(piece.size(), 0);
  for (const glm::uvec3& face : soup.faces) ++faces[piece[face.x]];
  RemovedPieces removed;
  for (const std::size_t count : faces) {
    if (count == 0 || count >= fewest_faces) continue;
    ++removed.pieces;
    removed.faces += count;
  }
  std::erase_if(soup.faces, [&](const glm::uvec3& face) { return faces[piece[face.x]] < fewest_faces; });
  return removed;
}

}  // namespace lumatlas
