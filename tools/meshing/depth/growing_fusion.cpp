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
    first_vertex.resize(blocks.size(), kNoBlock);
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
    drop_of(first_vertex);
  }

  // Shows anew what has changed, or everything, and returns the blocks in the order in which the surface has them.
  std::vector<std::uint32_t> show_changed(Show what) {
    for (std::uint32_t block = 0; block < blocks.size(); ++block) {
      const bool more = what == Show::everything ? weight[block] > shown_weight[block]
                                                 : weight[block] > (1 + kShownAnew) * shown_weight[block];
      if (more || lost[block] != 0) show(block);
    }
    std::vector<std::uint32_t> order(blocks.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return block_key(blocks[a]) < block_key(blocks[b]); });
    return order;
  }

  // Takes the vertices of the last surface out of the blocks that are cut anew; empty of the others.
  std::vector<BlockVertices> take_outdated() {
    std::vector<BlockVertices> outdated(blocks.size());
    for (std::uint32_t block = 0; block < blocks.size(); ++block) {
      if (!vertices[block].is_cut && first_vertex[block] != kNoBlock) std::swap(outdated[block], vertices[block]);
    }
    return outdated;
  }

  // Appends the previous positions of a block's vertices.
  void append_previous(std::uint32_t block, bool was_cut_anew, const BlockVertices& before,
                       std::vector<VertexId>& previous) const {
    const BlockVertices& now = vertices[block];
    const std::uint32_t first = first_vertex[block];
    std::size_t then = 0;
    for (std::size_t i = 0; i < now.cells.size(); ++i) {
      VertexId same;
      if (first != kNoBlock && !was_cut_anew) {
        same = VertexId(first + static_cast<std::uint32_t>(i));
      } else {
        while (then < before.cells.size() && before.cells[then] < now.cells[i]) ++then;
        if (then < before.cells.size() && before.cells[then] == now.cells[i] &&
            before.positions[then] == now.positions[i]) {
          same = VertexId(first + static_cast<std::uint32_t>(then));
        }
      }
      previous.push_back(same);
    }
  }

  FusionOptions options;
  double steps_of_weight;
  BlockIndex blocks;
  std::vector<SummedVoxels> voxels;                 // of all images
  std::vector<Voxels> shown;                        // those that the surface was cut out of last
  std::vector<std::uint64_t> weight, shown_weight;  // sums over the voxels of each block
  std::vector<std::uint8_t> lost;                   // 1: an image was taken out since the block was shown
  std::vector<BlockVertices> vertices;              // of what is shown
  std::vector<std::uint32_t> first_vertex;          // of each block in the last surface; kNoBlock: it was not there
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
  return grown_surface(what).soup;
}

GrownSoup GrowingFusion::grown_surface(Show what) {
  State& state = *state_;
  const std::vector<std::uint32_t> order = state.show_changed(what);
  std::vector<std::uint8_t> cut_anew(state.blocks.size());
  for (std::size_t block = 0; block < cut_anew.size(); ++block) cut_anew[block] = state.vertices[block].is_cut ? 0 : 1;
  const std::vector<BlockVertices> outdated = state.take_outdated();
  GrownSoup grown;
  grown.soup = surface_of(state.blocks, state.shown, order, state.options, state.vertices);
  grown.previous_position.reserve(grown.soup.positions.size());
  std::uint32_t first = 0;
  for (const std::uint32_t block : order) {
    state.append_previous(block, cut_anew[block] != 0, outdated[block], grown.previous_position);
    state.first_vertex[block] = first;
    first += static_cast<std::uint32_t>(state.vertices[block].cells.size());
  }
  return grown;
}

std::size_t GrowingFusion::blocks() const {
  return state_->blocks.size();
}

}  // namespace lumatlas
