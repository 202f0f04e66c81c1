// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to fusion: cuts the zero set out of a volume of signed distances, see depth_fusion.h.
#pragma once

#include <vector>

#include "mesh/mesh.h"
#include "tools/meshing/depth/fusion_blocks.h"

namespace lumatlas {

// Returns the surface of blocks, whose voxels are given by the blocks' numbers: see fused(). Vertices and faces come in
// the order of `order`, which has each block's number once.
[[nodiscard]] TriangleSoup surface_of(const BlockIndex& blocks, const std::vector<Voxels>& voxels,
                                      const std::vector<std::uint32_t>& order, const FusionOptions& options);

}  // namespace lumatlas
