// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/cut/small_pieces.h"

#include <boost/pending/disjoint_sets.hpp>
#include <vector>

namespace lumatlas {

RemovedPieces remove_small_pieces(TriangleSoup& soup, std::size_t fewest_faces) {
  boost::disjoint_sets_with_storage<> pieces(soup.positions.size());
  for (const glm::uvec3& face : soup.faces) {
    pieces.union_set(face.x, face.y);
    pieces.union_set(face.x, face.z);
  }
  std::vector<std::size_t> faces(soup.positions.size(), 0);  // faces of the piece whose representative the vertex is
  for (const glm::uvec3& face : soup.faces) ++faces[pieces.find_set(face.x)];
  RemovedPieces removed;
  for (const std::size_t count : faces) {
    if (count == 0 || count >= fewest_faces) continue;
    ++removed.pieces;
    removed.faces += count;
  }
  std::erase_if(soup.faces, [&](const glm::uvec3& face) { return faces[pieces.find_set(face.x)] < fewest_faces; });
  return removed;
}

}  // namespace lumatlas
