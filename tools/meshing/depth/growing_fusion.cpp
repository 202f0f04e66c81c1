// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/depth/growing_fusion.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <numeric>
#include <utility>
#include <vector>

#include "tools/meshing/depth/block_update.h"
#include "tools/meshing/depth/fusion_blocks.h"
#include "tools/meshing/depth/surface_nets.h"

namespace lumatlas {
namespace {

using glm::ivec3;

// The integers that a weight is rounded to: this many are FusionOptions::least_weight, and an image counts for no more
// than the most.
constexpr double kLeastSteps = 64;
constexpr double kMostSteps = 1 << 15;

// Integers, so that what was added can be taken out to the bit.
struct SummedVoxel {
  std::int32_t sum = 0;
  std::uint32_t weight = 0;
};
using SummedVoxels = std::array<SummedVoxel, kBlockVoxels>;

// A block is shown anew when its voxels have been seen by this share more than when it was shown last: twice as much.
// So a block is shown as often as the logarithm of what is seen of it, and what it would move by is below the noise
// that it was shown with.
constexpr std::uint64_t kShownAnew = 1;

}  // namespace

struct GrowingFusion::State {
  explicit State(const FusionOptions& fusion) : options(fusion), steps_of_weight(kLeastSteps / fusion.least_weight) {}

  void resize() {
    voxels.resize(blocks.size());
    shown.resize(blocks.size());
    weight.resize(blocks.size(), 0);
    shown_weight.resize(blocks.size(), 0);
    lost.resize(blocks.size(), 0);
    vertices.resize(blocks.size());
  }

  // Adds an image to a block, or with a `sign` of -1 takes it out.
  void change(const DepthImage& image, std::uint32_t block, int sign) {
    SummedVoxels& sums = voxels[block];
    BlockUpdate(image, options).visit(blocks[block], [&](std::size_t voxel, double image_weight, double distance) {
      const auto steps = static_cast<std::int32_t>(std::lround(std::min(steps_of_weight * image_weight, kMostSteps)));
      sums[voxel].weight += static_cast<std::uint32_t>(sign * steps);
      sums[voxel].sum += sign * static_cast<std::int32_t>(std::lround(steps * distance));
    });
    std::uint64_t sum = 0;
    for (const SummedVoxel& voxel : sums) sum += voxel.weight;
    weight[block] = sum;
  }

  void show(std::uint32_t block) {
    for (std::size_t voxel = 0; voxel < kBlockVoxels; ++voxel) {
      shown[block][voxel] = {static_cast<float>(voxels[block][voxel].sum / steps_of_weight),
                             static_cast<float>(voxels[block][voxel].weight / steps_of_weight)};
    }
    shown_weight[block] = weight[block];
    lost[block] = 0;
    forget_vertices(block);
  }

  // Forgets the vertices that depend on what a block shows: its own, and those of the blocks before it.
  void forget_vertices(std::uint32_t block) {
    for (int corner = 0; corner < 8; ++corner) {
      const std::uint32_t before = blocks.find(blocks[block] - ivec3(corner & 1, (corner >> 1) & 1, corner >> 2));
      if (before != kNoBlock) vertices[before].is_cut = false;
    }
  }

  // The block that was last gets its number.
  void drop(std::uint32_t block) {
    forget_vertices(block);
    blocks.remove(block);
    const auto drop_of = [&](auto& of_block) {
      if (block + 1 < of_block.size()) of_block[block] = std::move(of_block.back());
      of_block.pop_back();
    };
    drop_of(voxels);
    drop_of(shown);
    drop_of(weight);
    drop_of(shown_weight);
    drop_of(lost);
    drop_of(vertices);
  }

  FusionOptions options;
  double steps_of_weight;
  BlockIndex blocks;
  std::vector<SummedVoxels> voxels;                 // of all images
  std::vector<Voxels> shown;                        // those that the surface was cut out of last
  std::vector<std::uint64_t> weight, shown_weight;  // sums over the voxels of each block
  std::vector<std::uint8_t> lost;                   // 1: an image was taken out since the block was shown
  std::vector<BlockVertices> vertices;              // of what is shown
};

GrowingFusion::GrowingFusion(const FusionOptions& options) {
  check(options);
  state_ = std::make_unique<State>(options);
}

GrowingFusion::~GrowingFusion() = default;

bool GrowingFusion::add(const DepthImage& image) {
  check(image, 0);
  State& state = *state_;
  const std::vector<ivec3> near = blocks_near(image, state.options);
  const auto is_new = [&](const ivec3& block) { return state.blocks.find(block) == kNoBlock; };
  const auto added = static_cast<std::size_t>(std::count_if(near.begin(), near.end(), is_new));
  if (state.blocks.size() + added > state.options.max_blocks) return false;
  std::vector<std::uint32_t> numbers;
  numbers.reserve(near.size());
  for (const ivec3& block : near) numbers.push_back(state.blocks.add(block));
  state.resize();
  tbb::parallel_for(std::size_t{0}, numbers.size(), [&](std::size_t i) { state.change(image, numbers[i], 1); });
  return true;
}

void GrowingFusion::remove(const DepthImage& image) {
  check(image, 0);
  State& state = *state_;
  const std::vector<ivec3> near = blocks_near(image, state.options);
  tbb::parallel_for(std::size_t{0}, near.size(), [&](std::size_t i) {
    const std::uint32_t block = state.blocks.find(near[i]);
    if (block == kNoBlock) return;  // has gone since, because no image said anything of it
    state.change(image, block, -1);
    state.lost[block] = 1;
  });
  for (const ivec3& block : near) {
    const std::uint32_t number = state.blocks.find(block);
    if (number != kNoBlock && state.weight[number] == 0) state.drop(number);
  }
}

TriangleSoup GrowingFusion::surface(Show what) {
  State& state = *state_;
  for (std::uint32_t block = 0; block < state.blocks.size(); ++block) {
    const bool more = what == Show::everything ? state.weight[block] > state.shown_weight[block]
                                               : state.weight[block] > (1 + kShownAnew) * state.shown_weight[block];
    if (more || state.lost[block] != 0) state.show(block);
  }
  std::vector<std::uint32_t> order(state.blocks.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return block_key(state.blocks[a]) < block_key(state.blocks[b]); });
  return surface_of(state.blocks, state.shown, order, state.options, state.vertices);
}

std::size_t GrowingFusion::blocks() const {
  return state_->blocks.size();
}

}  // namespace lumatlas
