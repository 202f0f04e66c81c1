// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to fusion: cuts the zero set out of a volume of signed distances, see depth_fusion.h.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "mesh/mesh.h"
#include "tools/meshing/depth/fusion_blocks.h"

namespace lumatlas {

// The vertices of a block, one in each cell that the surface crosses.
struct BlockVertices {
  bool is_cut = false;               // false: they are to be found
  std::vector<std::uint16_t> cells;  // index_in_block() of their first corners, ascending
  std::vector<glm::dvec3> positions;
};

// Returns the surface of blocks, whose voxels and vertices are given by the blocks' numbers: see fused(). Vertices that
// are not cut are found first; they depend on the block's voxels and on those of the seven blocks after it. Vertices
// and faces come in the order of `order`, which has each block's number once, and are the same for any number of
// threads.
[[nodiscard]] TriangleSoup surface_of(const BlockIndex& blocks, const std::vector<Voxels>& voxels,
                                      const std::vector<std::uint32_t>& order, const FusionOptions& options,
                                      std::vector<BlockVertices>& vertices);

}  // namespace lumatlas
