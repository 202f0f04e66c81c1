// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to fusion: pieces of a surface that hang together with nothing else, found block by block. A block's part of
// the work is kept as long as its faces are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tools/meshing/depth/surface_nets.h"

namespace lumatlas {

// The parts in which the faces of a block hang together.
struct BlockPieces {
  struct Piece {
    std::uint32_t faces = 0;
    // A vertex of the piece, and those of its vertices that other blocks' faces may have.
    std::vector<CornerCode> vertices;
  };
  std::vector<Piece> pieces;
  std::vector<std::uint16_t> piece_of_face;
};

[[nodiscard]] BlockPieces pieces_in(const BlockSurface& surface);

// Returns for each block, ascending, which of its pieces are parts of pieces of the surface that have fewer than
// `fewest_faces`. `corners` and `pieces` are given by the blocks' numbers. Faces that share a vertex are of one piece.
[[nodiscard]] std::vector<std::vector<std::uint16_t>> small_pieces(const std::vector<BlockPieces>& pieces,
                                                                   const std::vector<BlockCorners>& corners,
                                                                   std::size_t vertices, std::size_t fewest_faces);

}  // namespace lumatlas
