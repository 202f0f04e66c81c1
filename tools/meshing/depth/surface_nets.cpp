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
  SurfaceExtraction(const BlockIndex& blocks, const std::vector<Voxels>& voxels,
                    const std::vector<std::uint32_t>& order, const FusionOptions& options,
                    std::vector<BlockVertices>& vertices)
      : options_(options), blocks_(blocks), voxels_(voxels), order_(order), vertices_(vertices) {}

  TriangleSoup surface() {
    vertex_of_cell_.resize(blocks_.size() * kBlockVoxels);
    tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(blocks_.size()), [&](std::uint32_t block) {
      if (!vertices_[block].is_cut) vertices_[block] = cut(block);
    });
    std::vector<std::uint32_t> first(blocks_.size());  // vertex of each block
    std::uint32_t count = 0;
    for (const std::uint32_t block : order_) {
      first[block] = count;
      count += static_cast<std::uint32_t>(vertices_[block].cells.size());
    }
    surface_.positions.resize(count);
    tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(blocks_.size()), [&](std::uint32_t block) {
      const BlockVertices& vertices = vertices_[block];
      const auto of_block = vertex_of_cell_.begin() + static_cast<std::ptrdiff_t>(block * kBlockVoxels);
      std::fill(of_block, of_block + kBlockVoxels, kNoBlock);
      for (std::uint32_t i = 0; i < vertices.cells.size(); ++i) {
        of_block[vertices.cells[i]] = first[block] + i;
        surface_.positions[first[block] + i] = vertices.positions[i];
      }
    });
    std::vector<std::vector<glm::uvec3>> faces(blocks_.size());
    tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(blocks_.size()),
                      [&](std::uint32_t block) { add_faces(block, faces[block]); });
    for (const std::uint32_t block : order_) {
      surface_.faces.insert(surface_.faces.end(), faces[block].begin(), faces[block].end());
    }
    return std::move(surface_);
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

  [[nodiscard]] BlockVertices cut(std::uint32_t block) const {
    const BlocksAround around = blocks_around(block);
    BlockVertices vertices;
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

  // kNoBlock: the surface does not cross that cell, or not all of it was seen.
  [[nodiscard]] std::uint32_t vertex_at(const ivec3& cell) const {
    const ivec3 in = block_of(cell);
    const std::uint32_t block = blocks_.find(in);
    return block == kNoBlock ? kNoBlock
                             : vertex_of_cell_[block * kBlockVoxels + index_in_block(cell - kBlockSide * in)];
  }

  [[nodiscard]] bool is_inside(std::uint32_t block, const ivec3& at) const {
    return voxels_[block][index_in_block(at)].sum < 0;
  }

  // A quad for each edge that starts at a cell's first corner and crosses the surface, between the four cells around.
  void add_faces(std::uint32_t block, std::vector<glm::uvec3>& faces) const {
    if (vertices_[block].cells.empty()) return;
    const BlocksAround around = blocks_around(block);
    for (const std::uint16_t index : vertices_[block].cells) {
      const ivec3 cell = cell_at(index);
      const bool inside = is_inside(block, cell);
      for (int axis = 0; axis < 3; ++axis) {
        ivec3 end = cell;
        ++end[axis];
        const ivec3 beyond = block_of(end);
        if (is_inside(around[place_of(beyond)], end - kBlockSide * beyond) != inside) {
          add_quad(kBlockSide * blocks_[block] + cell, axis, inside, faces);
        }
      }
    }
  }

  // Round the edge along `axis` from the first corner of `cell`; it faces the edge's end if the edge comes from inside.
  void add_quad(const ivec3& cell, int axis, bool from_inside, std::vector<glm::uvec3>& faces) const {
    ivec3 b(0);
    ivec3 c(0);
    b[(axis + 1) % 3] = 1;
    c[(axis + 2) % 3] = 1;
    std::array<std::uint32_t, 4> v{vertex_at(cell), vertex_at(cell - b), vertex_at(cell - b - c), vertex_at(cell - c)};
    if (std::find(v.begin(), v.end(), kNoBlock) != v.end()) return;
    if (!from_inside) std::swap(v[1], v[3]);
    const auto length = [&](std::uint32_t from, std::uint32_t to) {
      return glm::distance(surface_.positions[from], surface_.positions[to]);
    };
    if (length(v[1], v[3]) < length(v[0], v[2])) std::rotate(v.begin(), v.begin() + 1, v.end());
    faces.emplace_back(v[0], v[1], v[2]);
    faces.emplace_back(v[0], v[2], v[3]);
  }

  const FusionOptions& options_;
  const BlockIndex& blocks_;
  const std::vector<Voxels>& voxels_;
  const std::vector<std::uint32_t>& order_;
  std::vector<BlockVertices>& vertices_;
  std::vector<std::uint32_t> vertex_of_cell_;  // per block and its cells, by their first corners
  TriangleSoup surface_;
};

}  // namespace

TriangleSoup surface_of(const BlockIndex& blocks, const std::vector<Voxels>& voxels,
                        const std::vector<std::uint32_t>& order, const FusionOptions& options,
                        std::vector<BlockVertices>& vertices) {
  return SurfaceExtraction(blocks, voxels, order, options, vertices).surface();
}

}  // namespace lumatlas
