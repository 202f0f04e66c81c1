// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: the tiles of a surface in chunks, level by level, as 3D Tiles has them.
#pragma once

#include <cstddef>
#include <vector>

namespace lumatlas {

// Tiles below one tile, at most.
inline constexpr std::size_t kChildTiles = 8;

// A tile that stands in for the chunks `first` to `first + count - 1` until its children are there.
struct TileRange {
  std::size_t first = 0, count = 0;
  std::vector<TileRange> children;  // in the order of their chunks; a chunk has none
};

// Returns the root of the tiles of `chunks` chunks, at least one. All chunks are equally deep and in their order, and
// the numbers of chunks below tiles beside each other differ by at most one.
[[nodiscard]] TileRange tile_tree(std::size_t chunks);

}  // namespace lumatlas
