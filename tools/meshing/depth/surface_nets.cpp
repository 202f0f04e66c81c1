// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/depth/surface_nets.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <utility>

namespace lumatlas {
namespace {

using glm::dvec3;
using glm::ivec3;

using Corners = std::array<float, 8>;               // distances at the corners x + 2 y + 4 z of a cell
using BlocksAround = std::array<std::uint32_t, 8>;  // the block itself and those after it, in the same order

ivec3 offset(int corner) {
  return {corner & 1, (corner >> 1) & 1, corner >> 2};
}

// Returns the place of a block among BlocksAround.
std::size_t place_of(const ivec3& beyond) {
  const auto part = [](int i) { return static_cast<std::size_t>(i); };
  return part(beyond.x) + 2 * part(beyond.y) + 4 * part(beyond.z);
}

// In cells, from the cell's first corner: the mean of where the surface crosses the cell's edges; none if it does not.
bool find_crossing(const Corners& corners, dvec3& crossing) {
  dvec3 sum(0.0);
  int count = 0;
  for (int from = 0; from < 8; ++from) {
    for (int axis = 0; axis < 3; ++axis) {
      const int to = from | (1 << axis);
      const float a = corners[static_cast<std::size_t>(from)];
      const float b = corners[static_cast<std::size_t>(to)];
      if (to == from || (a < 0) == (b < 0)) continue;
      dvec3 at(offset(from));
      at[axis] = static_cast<double>(a) / (static_cast<double>(a) - b);
      sum += at;
      ++count;
    }
  }
  if (count > 0) crossing = sum / static_cast<double>(count);
  return count > 0;
}

ivec3 cell_at(std::size_t index) {
  const int i = static_cast<int>(index);
  return {i % kBlockSide, i / kBlockSide % kBlockSide, i / (kBlockSide * kBlockSide)};
}

// Cuts the surface out of the voxels of blocks.
class SurfaceExtraction {
 public:
  SurfaceExtraction(const BlockIndex& blocks, const std::vector<Voxels>& voxels, const FusionOptions& options,
                    std::vector<BlockSurface>& surfaces)
      : options_(options), blocks_(blocks), voxels_(voxels), surfaces_(surfaces) {}

  void cut_vertices() {
    for (std::uint32_t block = 0; block < blocks_.size(); ++block) {
      if (surfaces_[block].is_cut) continue;
      for_blocks_with_corners_in(blocks_, blocks_[block],
                                 [&](std::uint32_t user) { surfaces_[user].has_faces = false; });
    }
    tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(blocks_.size()), [&](std::uint32_t block) {
      if (!surfaces_[block].is_cut) surfaces_[block] = cut(block);
    });
  }

  std::vector<std::uint8_t> cut_faces() {
    std::vector<std::uint8_t> found(blocks_.size(), 0);
    tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(blocks_.size()), [&](std::uint32_t block) {
      if (surfaces_[block].has_faces) return;
      BlockSurface& surface = surfaces_[block];
      surface.faces = faces(block);
      surface.blocks_used = 0;
      for (const std::array<CornerCode, 3>& face : surface.faces) {
        for (const CornerCode code : face) surface.blocks_used |= static_cast<std::uint8_t>(1U << corner_block(code));
      }
      surface.has_faces = true;
      found[block] = 1;
    });
    return found;
  }

 private:
  [[nodiscard]] BlocksAround blocks_around(std::uint32_t block) const {
    BlocksAround around{};
    for (int i = 0; i < 8; ++i) around[static_cast<std::size_t>(i)] = blocks_.find(blocks_[block] + offset(i));
    return around;
  }

  // Returns false if one of the corners was not seen.
  bool read_corners(const BlocksAround& around, const ivec3& cell, Corners& corners) const {
    for (int i = 0; i < 8; ++i) {
      const ivec3 at = cell + offset(i);
      const ivec3 beyond = block_of(at);
      const std::uint32_t block = around[place_of(beyond)];
      if (block == kNoBlock) return false;
      const Voxel& voxel = voxels_[block][index_in_block(at - kBlockSide * beyond)];
      if (voxel.weight < options_.least_weight) return false;
      corners[static_cast<std::size_t>(i)] = voxel.sum / voxel.weight;
    }
    return true;
  }

  [[nodiscard]] BlockSurface cut(std::uint32_t block) const {
    const BlocksAround around = blocks_around(block);
    BlockSurface vertices;
    vertices.is_cut = true;
    for (std::size_t index = 0; index < kBlockVoxels; ++index) {
      if (voxels_[block][index].weight < options_.least_weight) continue;
      const ivec3 cell = cell_at(index);
      Corners corners{};
      dvec3 crossing;
      if (!read_corners(around, cell, corners) || !find_crossing(corners, crossing)) continue;
      vertices.cells.push_back(static_cast<std::uint16_t>(index));
      vertices.positions.push_back(options_.voxel * (dvec3(kBlockSide * blocks_[block] + cell) + crossing));
    }
    return vertices;
  }

  [[nodiscard]] bool is_inside(std::uint32_t block, const ivec3& at) const {
    return voxels_[block][index_in_block(at)].sum < 0;
  }

  // A quad for each edge that starts at a cell's first corner and crosses the surface, between the four cells around.
  [[nodiscard]] std::vector<std::array<CornerCode, 3>> faces(std::uint32_t block) const {
    std::vector<std::array<CornerCode, 3>> faces;
    if (surfaces_[block].cells.empty()) return faces;
    const BlocksAround around = blocks_around(block);
    BlocksAround before{};
    for (std::size_t i = 0; i < 8; ++i) before[i] = blocks_.find(blocks_[block] - block_up_to(i));
    for (const std::uint16_t index : surfaces_[block].cells) {
      const ivec3 cell = cell_at(index);
      const bool inside = is_inside(block, cell);
      for (int axis = 0; axis < 3; ++axis) {
        ivec3 end = cell;
        ++end[axis];
        const ivec3 beyond = block_of(end);
        if (is_inside(around[place_of(beyond)], end - kBlockSide * beyond) != inside) {
          add_quad(before, cell, axis, inside, faces);
        }
      }
    }
    return faces;
  }

  // A corner of a quad.
  struct QuadCorner {
    CornerCode code;
    const dvec3* position;  // null: the surface does not cross that cell, or not all of it was seen
  };
  [[nodiscard]] QuadCorner corner_at(const BlocksAround& before, const ivec3& cell) const {
    const ivec3 in = block_of(cell);
    const std::size_t which = place_of(-in);
    if (before[which] == kNoBlock) return {0, nullptr};
    const BlockSurface& surface = surfaces_[before[which]];
    const auto index = static_cast<std::uint16_t>(index_in_block(cell - kBlockSide * in));
    const auto found = std::lower_bound(surface.cells.begin(), surface.cells.end(), index);
    if (found == surface.cells.end() || *found != index) return {0, nullptr};
    const auto vertex = static_cast<std::size_t>(found - surface.cells.begin());
    return {corner_code(which, vertex), &surface.positions[vertex]};
  }

  // Round the edge along `axis` from the first corner of `cell`; it faces the edge's end if the edge comes from inside.
  void add_quad(const BlocksAround& before, const ivec3& cell, int axis, bool from_inside,
                std::vector<std::array<CornerCode, 3>>& faces) const {
    ivec3 b(0);
    ivec3 c(0);
    b[(axis + 1) % 3] = 1;
    c[(axis + 2) % 3] = 1;
    std::array<QuadCorner, 4> v{corner_at(before, cell), corner_at(before, cell - b), corner_at(before, cell - b - c),
                                corner_at(before, cell - c)};
    if (std::any_of(v.begin(), v.end(), [](const QuadCorner& corner) { return corner.position == nullptr; })) return;
    if (!from_inside) std::swap(v[1], v[3]);
    const auto length = [](const QuadCorner& from, const QuadCorner& to) {
      return glm::distance(*from.position, *to.position);
    };
    if (length(v[1], v[3]) < length(v[0], v[2])) std::rotate(v.begin(), v.begin() + 1, v.end());
    faces.push_back({v[0].code, v[1].code, v[2].code});
    faces.push_back({v[0].code, v[2].code, v[3].code});
  }

  const FusionOptions& options_;
  const BlockIndex& blocks_;
  const std::vector<Voxels>& voxels_;
  std::vector<BlockSurface>& surfaces_;
};

}  // namespace

std::vector<std::uint8_t> cut_surfaces(const BlockIndex& blocks, const std::vector<Voxels>& voxels,
                                       const FusionOptions& options, std::vector<BlockSurface>& surfaces) {
  SurfaceExtraction extraction(blocks, voxels, options, surfaces);
  extraction.cut_vertices();
  return extraction.cut_faces();
}

BlockCorners::BlockCorners(const BlockIndex& blocks, const std::vector<BlockSurface>& surfaces,
                           const std::vector<std::uint32_t>& first_vertex, std::uint32_t block) {
  for (std::size_t i = 0; i < 8; ++i) {
    if ((surfaces[block].blocks_used >> i & 1U) == 0) continue;
    first_vertex_.at(i) = first_vertex[blocks.find(blocks[block] - block_up_to(i))];
  }
}

std::vector<std::uint32_t> first_vertices(const std::vector<BlockSurface>& surfaces,
                                          const std::vector<std::uint32_t>& order, std::size_t& count) {
  std::vector<std::uint32_t> first(surfaces.size());
  count = 0;
  for (const std::uint32_t block : order) {
    first[block] = static_cast<std::uint32_t>(count);
    count += surfaces[block].cells.size();
  }
  return first;
}

TriangleSoup surface_of(const BlockIndex& blocks, const std::vector<Voxels>& voxels,
                        const std::vector<std::uint32_t>& order, const FusionOptions& options) {
  std::vector<BlockSurface> surfaces(blocks.size());
  (void)cut_surfaces(blocks, voxels, options, surfaces);
  TriangleSoup soup;
  std::size_t count = 0;
  const std::vector<std::uint32_t> first_vertex = first_vertices(surfaces, order, count);
  soup.positions.reserve(count);
  for (const std::uint32_t block : order) {
    const BlockSurface& surface = surfaces[block];
    soup.positions.insert(soup.positions.end(), surface.positions.begin(), surface.positions.end());
    const BlockCorners corners(blocks, surfaces, first_vertex, block);
    for (const std::array<CornerCode, 3>& face : surface.faces) soup.faces.push_back(corners.face(face));
  }
  return soup;
}

}  // namespace lumatlas
