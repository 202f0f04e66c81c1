// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/surface/tile_tree.h"

namespace lumatlas {

namespace {

// `capacity`: the chunks that each child may stand for, a power of kChildTiles.
TileRange tile_of(std::size_t first, std::size_t count, std::size_t capacity) {
  TileRange tile{first, count, {}};
  const std::size_t children = (count + capacity - 1) / capacity;
  std::size_t at = 0;
  for (std::size_t child = 0; child < children; ++child) {
    const std::size_t end = count * (child + 1) / children;
    if (capacity == 1) {
      tile.children.push_back({first + at, 1, {}});
    } else {
      tile.children.push_back(tile_of(first + at, end - at, capacity / kChildTiles));
    }
    at = end;
  }
  return tile;
}

}  // namespace

TileRange tile_tree(std::size_t chunks) {
  if (chunks == 1) return {0, 1, {}};
  std::size_t capacity = 1;
  while (capacity * kChildTiles < chunks) capacity *= kChildTiles;
  return tile_of(0, chunks, capacity);
}

}  // namespace lumatlas
