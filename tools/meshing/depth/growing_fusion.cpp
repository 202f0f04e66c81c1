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

#include "tools/meshing/depth/block_pieces.h"
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

// A block's part of a surface.
struct BlockInSurface {
  std::uint32_t first_vertex = kNoBlock;  // kNoBlock: the block was not there
  std::uint32_t first_face = 0;
  std::vector<std::uint16_t> small;  // the block's pieces that the surface has not, see small_pieces()
};

// What was cut anew for a surface, by block.
struct CutAnew {
  std::vector<std::uint8_t> vertices, faces;  // 1: they were found anew
  std::vector<BlockSurface> vertices_before;  // empty where they stay
};

}  // namespace

struct GrowingFusion::State {
  explicit State(const FusionOptions& fusion) : options(fusion), steps_of_weight(kLeastSteps / fusion.least_weight) {}

  void resize() {
    voxels.resize(blocks.size());
    shown.resize(blocks.size());
    weight.resize(blocks.size(), 0);
    shown_weight.resize(blocks.size(), 0);
    lost.resize(blocks.size(), 0);
    surfaces.resize(blocks.size());
    pieces.resize(blocks.size());
    last.resize(blocks.size());
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
      if (before != kNoBlock) surfaces[before].is_cut = false;
    }
  }

  // The block that was last gets its number.
  void drop(std::uint32_t block) {
    forget_vertices(block);
    for_blocks_with_corners_in(blocks, blocks[block], [&](std::uint32_t user) { surfaces[user].has_faces = false; });
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
    drop_of(surfaces);
    drop_of(pieces);
    drop_of(last);
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

  // Cuts what is outdated, and notes the pieces of the faces that were found.
  CutAnew cut() {
    CutAnew anew;
    anew.vertices.resize(blocks.size());
    anew.vertices_before.resize(blocks.size());
    for (std::uint32_t block = 0; block < blocks.size(); ++block) {
      if (surfaces[block].is_cut) continue;
      anew.vertices[block] = 1;
      std::swap(anew.vertices_before[block], surfaces[block]);
    }
    anew.faces = cut_surfaces(blocks, shown, options, surfaces);
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
      if (anew.faces[block] != 0) pieces[block] = pieces_in(surfaces[block]);
    });
    return anew;
  }

  // Returns where each block's vertices and faces begin in a surface without the faces of small pieces.
  [[nodiscard]] std::vector<BlockInSurface> begins(const std::vector<std::uint32_t>& order,
                                                   const std::vector<std::uint32_t>& first_vertex,
                                                   std::vector<std::vector<std::uint16_t>> small,
                                                   std::size_t& count) const {
    std::vector<BlockInSurface> begins(blocks.size());
    count = 0;
    for (const std::uint32_t block : order) {
      begins[block] = {first_vertex[block], static_cast<std::uint32_t>(count), std::move(small[block])};
      count += surfaces[block].faces.size();
      for (const std::uint16_t piece : begins[block].small) count -= pieces[block].pieces[piece].faces;
    }
    return begins;
  }

  // Copies a block's vertices to a surface, and finds which ones they were.
  void copy_vertices(std::uint32_t block, const CutAnew& anew, const BlockInSurface& was, const BlockInSurface& begin,
                     GrownSoup& grown) const {
    const BlockSurface& now = surfaces[block];
    const BlockSurface& before = anew.vertices_before[block];
    std::copy(now.positions.begin(), now.positions.end(),
              grown.soup.positions.begin() + static_cast<std::ptrdiff_t>(begin.first_vertex));
    const std::uint32_t first = was.first_vertex;
    if (first == kNoBlock) return;
    std::uint32_t then = 0;
    for (std::size_t i = 0; i < now.cells.size(); ++i) {
      VertexId& previous = grown.previous_position[begin.first_vertex + i];
      if (anew.vertices[block] == 0) {
        previous = VertexId(first + static_cast<std::uint32_t>(i));
        continue;
      }
      while (then < before.cells.size() && before.cells[then] < now.cells[i]) ++then;
      if (then < before.cells.size() && before.cells[then] == now.cells[i] &&
          before.positions[then] == now.positions[i]) {
        previous = VertexId(first + then);
      }
    }
  }

  // Copies a block's faces to a surface, and says which ones they were unless they were found anew.
  void copy_faces(std::uint32_t block, bool stays, const BlockCorners& corners, const BlockInSurface& was,
                  const BlockInSurface& begin, GrownSoup& grown) const {
    const auto is_in = [&](const BlockInSurface& surface, std::size_t face) {
      return surface.small.empty() ||
             !std::binary_search(surface.small.begin(), surface.small.end(), pieces[block].piece_of_face[face]);
    };
    std::uint32_t next = begin.first_face, next_before = was.first_face;
    for (std::size_t face = 0; face < surfaces[block].faces.size(); ++face) {
      const bool was_there = stays && was.first_vertex != kNoBlock && is_in(was, face);
      if (is_in(begin, face)) {
        if (was_there) grown.previous_face[next] = FaceId(next_before);
        grown.soup.faces[next++] = corners.face(surfaces[block].faces[face]);
      }
      if (was_there) ++next_before;
    }
  }

  [[nodiscard]] GrownSoup next_surface(const std::vector<std::uint32_t>& order, std::size_t fewest_faces) {
    const bool follows = std::exchange(has_last, false);  // until this one is made
    // A call that threw may have found faces and not their pieces.
    for (std::size_t block = 0; !follows && block < blocks.size(); ++block) surfaces[block].has_faces = false;
    const CutAnew anew = cut();
    std::size_t vertices = 0, faces = 0;
    const std::vector<std::uint32_t> first_vertex = first_vertices(surfaces, order, vertices);
    std::vector<BlockCorners> corners(blocks.size());
    const auto for_blocks = [&](const auto& run) {
      tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(blocks.size()), run);
    };
    for_blocks([&](std::uint32_t block) { corners[block] = BlockCorners(blocks, surfaces, first_vertex, block); });
    std::vector<BlockInSurface> now =
        begins(order, first_vertex, small_pieces(pieces, corners, vertices, fewest_faces), faces);
    GrownSoup grown;
    grown.soup.positions.resize(vertices);
    grown.soup.faces.resize(faces);
    grown.previous_position.resize(vertices);
    grown.previous_face.resize(faces);
    const std::vector<BlockInSurface> nothing(follows ? 0 : blocks.size());
    const std::vector<BlockInSurface>& before = follows ? last : nothing;
    for_blocks([&](std::uint32_t block) {
      copy_vertices(block, anew, before[block], now[block], grown);
      copy_faces(block, anew.faces[block] == 0, corners[block], before[block], now[block], grown);
    });
    last = std::move(now);
    has_last = true;
    return grown;
  }

  FusionOptions options;
  double steps_of_weight;
  BlockIndex blocks;
  std::vector<SummedVoxels> voxels;                 // of all images
  std::vector<Voxels> shown;                        // those that the surface was cut out of last
  std::vector<std::uint64_t> weight, shown_weight;  // sums over the voxels of each block
  std::vector<std::uint8_t> lost;                   // 1: an image was taken out since the block was shown
  std::vector<BlockSurface> surfaces;               // of what is shown
  std::vector<BlockPieces> pieces;                  // of these, where they have faces
  std::vector<BlockInSurface> last;                 // by block, of the last surface
  bool has_last = false;                            // false: there is none, or the call for it has thrown
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

GrownSoup GrowingFusion::grown_surface(Show what, std::size_t fewest_faces) {
  State& state = *state_;
  const std::vector<std::uint32_t> order = state.show_changed(what);
  return state.next_surface(order, fewest_faces);
}

std::size_t GrowingFusion::blocks() const {
  return state_->blocks.size();
}

}  // namespace lumatlas
