// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to fusion: the blocks of voxels that a volume exists in, and those that an image needs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "tools/meshing/depth/depth_fusion.h"

namespace lumatlas {

inline constexpr int kBlockSide = 8;  // voxels along a block's edge
inline constexpr std::size_t kBlockVoxels = std::size_t{kBlockSide} * kBlockSide * kBlockSide;
inline constexpr std::uint32_t kNoBlock = std::numeric_limits<std::uint32_t>::max();

struct Voxel {
  float sum = 0;  // sum of weight times distance, in units of the truncation, in [-1, 1]; positive in the open
  float weight = 0;
};
using Voxels = std::array<Voxel, kBlockVoxels>;

[[nodiscard]] inline std::size_t index_in_block(const glm::ivec3& v) {  // takes v in [0, kBlockSide)^3
  const auto part = [](int i) { return static_cast<std::size_t>(i); };
  return (part(v.z) * kBlockSide + part(v.y)) * kBlockSide + part(v.x);
}

inline constexpr int kBlockReach = (1 << 20) - 2;  // blocks from the origin that measurements are within

// Returns a block's number, ordered like (x, y, z).
[[nodiscard]] std::uint64_t block_key(const glm::ivec3& block);
[[nodiscard]] bool by_block_key(const glm::ivec3& a, const glm::ivec3& b);

// Returns the block that a voxel is in.
[[nodiscard]] inline glm::ivec3 block_of(const glm::ivec3& voxel) {
  return {voxel.x >> 3, voxel.y >> 3, voxel.z >> 3};
}

// Returns the blocks with voxels within the truncation of a measurement, along the rays, sorted by key, each once; one
// voxel more in all directions, since the surface is cut out of cells with eight voxels. Throws std::invalid_argument
// for a depth that is too far from the origin.
[[nodiscard]] std::vector<glm::ivec3> blocks_near(const DepthImage& image, const FusionOptions& options);

// Numbers the blocks that a volume has, by their coordinates.
class BlockIndex {
 public:
  // Adds a block unless it is there, and returns its number.
  std::uint32_t add(const glm::ivec3& block) {
    const auto [entry, added] = number_.emplace(block_key(block), static_cast<std::uint32_t>(blocks_.size()));
    if (added) blocks_.push_back(block);
    return entry->second;
  }
  // Returns kNoBlock if there is no such block.
  [[nodiscard]] std::uint32_t find(const glm::ivec3& block) const {
    const auto found = number_.find(block_key(block));
    return found == number_.end() ? kNoBlock : found->second;
  }
  // Removes a block, whose number then is that of the block that was last.
  void remove(std::uint32_t number) {
    number_.erase(block_key(blocks_[number]));
    if (number + 1 < blocks_.size()) {
      blocks_[number] = blocks_.back();
      number_[block_key(blocks_[number])] = number;
    }
    blocks_.pop_back();
  }
  [[nodiscard]] std::size_t size() const { return blocks_.size(); }
  [[nodiscard]] const glm::ivec3& operator[](std::size_t number) const { return blocks_[number]; }

 private:
  std::vector<glm::ivec3> blocks_;
  std::unordered_map<std::uint64_t, std::uint32_t> number_;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const FusionOptions& options);

}  // namespace lumatlas
