// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to fusion: cuts the zero set out of a volume of signed distances, see depth_fusion.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "mesh/mesh.h"
#include "tools/meshing/depth/fusion_blocks.h"

namespace lumatlas {

// Names a vertex for the faces of a block, which use vertices of eight blocks: the block, block_up_to() of
// corner_block() before their own, and the vertex's number in it. So kBlockVoxels + 1 is vertex 1 of block 1 of eight.
using CornerCode = std::uint16_t;

// `block` is below 8, and `vertex` below kBlockVoxels.
[[nodiscard]] inline CornerCode corner_code(std::size_t block, std::size_t vertex) {
  return static_cast<CornerCode>(block * kBlockVoxels + vertex);
}
[[nodiscard]] inline std::size_t corner_block(CornerCode code) {
  return code / kBlockVoxels;
}
[[nodiscard]] inline std::size_t corner_vertex(CornerCode code) {
  return code % kBlockVoxels;
}
// Returns what the coordinates of the eight blocks are less than those of the one whose faces use them; 0: itself.
[[nodiscard]] inline glm::ivec3 block_up_to(std::size_t block) {
  const auto i = static_cast<int>(block);
  return {i & 1, (i >> 1) & 1, i >> 2};
}

// The surface in a block: a vertex in each cell that it crosses, and the faces around edges that start in the block.
// Vertices depend on the block's voxels and on those of the seven blocks after it, and faces on the vertices of eight
// blocks.
struct BlockSurface {
  bool is_cut = false;               // false: the vertices are to be found
  bool has_faces = false;            // false: the faces are to be found
  std::vector<std::uint16_t> cells;  // index_in_block() of their first corners, ascending
  std::vector<glm::dvec3> positions;
  std::vector<std::array<CornerCode, 3>> faces;
  std::uint8_t blocks_used = 0;  // a bit for each block up to this one that faces have a vertex of
};

// Calls the function with the number of each block, of those that there are, whose faces use vertices of the block at
// `place`.
template <typename Function>
void for_blocks_with_corners_in(const BlockIndex& blocks, const glm::ivec3& place, const Function& function) {
  for (std::size_t i = 0; i < 8; ++i) {
    const std::uint32_t block = blocks.find(place + block_up_to(i));
    if (block != kNoBlock) function(block);
  }
}

// Finds the vertices that are to be found, and the faces that are to be found or may use such a vertex. Returns for
// each block whether its faces were found. Blocks' voxels and surfaces are given by the blocks' numbers.
std::vector<std::uint8_t> cut_surfaces(const BlockIndex& blocks, const std::vector<Voxels>& voxels,
                                       const FusionOptions& options, std::vector<BlockSurface>& surfaces);

// The vertices of a block's faces in a surface that has the vertices of all blocks, block by block.
class BlockCorners {
 public:
  BlockCorners() = default;
  // `first_vertex`: of each block, where its vertices begin.
  BlockCorners(const BlockIndex& blocks, const std::vector<BlockSurface>& surfaces,
               const std::vector<std::uint32_t>& first_vertex, std::uint32_t block);
  [[nodiscard]] std::uint32_t vertex(CornerCode code) const {
    return first_vertex_[corner_block(code)] + static_cast<std::uint32_t>(corner_vertex(code));
  }
  [[nodiscard]] glm::uvec3 face(const std::array<CornerCode, 3>& codes) const {
    return {vertex(codes[0]), vertex(codes[1]), vertex(codes[2])};
  }

 private:
  std::array<std::uint32_t, 8> first_vertex_{};  // of the blocks that faces use
};

// Returns where the vertices of each block begin in a surface that has the blocks in the order of `order`, and sets
// `count` to the number of all.
[[nodiscard]] std::vector<std::uint32_t> first_vertices(const std::vector<BlockSurface>& surfaces,
                                                        const std::vector<std::uint32_t>& order, std::size_t& count);

// Returns the surface of blocks: see fused(). Vertices and faces come in the order of `order`, which has each block's
// number once, and are the same for any number of threads.
[[nodiscard]] TriangleSoup surface_of(const BlockIndex& blocks, const std::vector<Voxels>& voxels,
                                      const std::vector<std::uint32_t>& order, const FusionOptions& options);

}  // namespace lumatlas
