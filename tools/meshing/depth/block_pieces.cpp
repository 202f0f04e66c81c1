// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/depth/block_pieces.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

namespace lumatlas {

namespace {

constexpr std::size_t kCorners = 8 * kBlockVoxels;
constexpr std::uint16_t kNoPiece = std::numeric_limits<std::uint16_t>::max();

// Sets of numbers, told by the least of each.
template <typename Number, typename Parents>
class LeastSets {
 public:
  explicit LeastSets(Parents parents) : parent_(std::move(parents)) {
    std::iota(parent_.begin(), parent_.end(), Number{0});
  }
  Number find(Number number) {
    while (parent_[number] != number) {
      parent_[number] = parent_[parent_[number]];
      number = parent_[number];
    }
    return number;
  }
  void join(Number a, Number b) {
    const Number first = find(a), second = find(b);
    parent_[std::max(first, second)] = std::min(first, second);
  }

 private:
  Parents parent_;
};

// Returns whether faces of other blocks may have a vertex that faces of a block have.
bool is_shared(const BlockSurface& surface, CornerCode code) {
  if (corner_block(code) != 0) return true;
  constexpr std::size_t kLast = kBlockSide - 1;
  const std::size_t cell = surface.cells[corner_vertex(code)];
  return cell % kBlockSide == kLast || cell / kBlockSide % kBlockSide == kLast ||
         cell / (kBlockSide * kBlockSide) == kLast;
}

}  // namespace

BlockPieces pieces_in(const BlockSurface& surface) {
  BlockPieces result;
  if (surface.faces.empty()) return result;
  LeastSets<std::uint16_t, std::array<std::uint16_t, kCorners>> sets({});
  for (const std::array<CornerCode, 3>& face : surface.faces) {
    sets.join(face[0], face[1]);
    sets.join(face[0], face[2]);
  }
  std::array<std::uint16_t, kCorners> piece_of_set{};
  piece_of_set.fill(kNoPiece);
  std::array<bool, kCorners> is_listed{};
  result.piece_of_face.reserve(surface.faces.size());
  for (const std::array<CornerCode, 3>& face : surface.faces) {
    std::uint16_t& number = piece_of_set.at(sets.find(face[0]));
    if (number == kNoPiece) {
      number = static_cast<std::uint16_t>(result.pieces.size());
      result.pieces.push_back({0, {face[0]}});
      is_listed.at(face[0]) = true;
    }
    BlockPieces::Piece& piece = result.pieces[number];
    ++piece.faces;
    for (const CornerCode code : face) {
      if (is_listed.at(code) || !is_shared(surface, code)) continue;
      is_listed.at(code) = true;
      piece.vertices.push_back(code);
    }
    result.piece_of_face.push_back(number);
  }
  return result;
}

std::vector<std::vector<std::uint16_t>> small_pieces(const std::vector<BlockPieces>& pieces,
                                                     const std::vector<BlockCorners>& corners, std::size_t vertices,
                                                     std::size_t fewest_faces) {
  std::vector<std::vector<std::uint16_t>> small(pieces.size());
  if (fewest_faces <= 1) return small;
  LeastSets<std::uint32_t, std::vector<std::uint32_t>> sets{std::vector<std::uint32_t>(vertices)};
  for (std::size_t block = 0; block < pieces.size(); ++block) {
    for (const BlockPieces::Piece& piece : pieces[block].pieces) {
      const std::uint32_t first = corners[block].vertex(piece.vertices.front());
      for (const CornerCode code : piece.vertices) sets.join(first, corners[block].vertex(code));
    }
  }
  std::vector<std::uint32_t> faces(vertices, 0);  // by the least vertex of a piece
  const auto faces_with = [&](std::size_t block, const BlockPieces::Piece& piece) -> std::uint32_t& {
    return faces[sets.find(corners[block].vertex(piece.vertices.front()))];
  };
  for (std::size_t block = 0; block < pieces.size(); ++block) {
    for (const BlockPieces::Piece& piece : pieces[block].pieces) faces_with(block, piece) += piece.faces;
  }
  for (std::size_t block = 0; block < pieces.size(); ++block) {
    for (std::size_t i = 0; i < pieces[block].pieces.size(); ++i) {
      if (faces_with(block, pieces[block].pieces[i]) >= fewest_faces) continue;
      small[block].push_back(static_cast<std::uint16_t>(i));
    }
  }
  return small;
}

}  // namespace lumatlas
