// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/grid_chunks.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/glm.hpp>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

namespace lumatlas {

namespace {

constexpr std::int32_t kFarCube = 1 << 20;  // a cube's largest number along an axis
constexpr std::size_t kMostLargeCells = 256;
constexpr double kRoundingOfSpheres = 1e-6;  // share of a box's size and distance

std::uint64_t mixed(std::uint64_t bits) {
  bits = (bits ^ bits >> 30U) * 0xbf58476d1ce4e5b9ull;
  bits = (bits ^ bits >> 27U) * 0x94d049bb133111ebull;
  return bits ^ bits >> 31U;
}

std::uint64_t hash_of(const glm::vec3& position) {
  const auto bits = [](float coordinate) { return std::uint64_t{std::bit_cast<std::uint32_t>(coordinate + 0.0F)}; };
  return mixed(mixed(bits(position.x) | bits(position.y) << 32U) + bits(position.z));
}

// Puts two zeros before each of a number's lowest 21 bits.
std::uint64_t spread_to_thirds(std::uint64_t bits) {
  bits = (bits | bits << 32U) & 0x001F00000000FFFFull;
  bits = (bits | bits << 16U) & 0x001F0000FF0000FFull;
  bits = (bits | bits << 8U) & 0x100F00F00F00F00Full;
  bits = (bits | bits << 4U) & 0x10C30C30C30C30C3ull;
  return (bits | bits << 2U) & 0x1249249249249249ull;
}

std::uint64_t hash_of_cells(std::span<const CellId> cells, std::span<const std::uint64_t> hashes) {
  std::uint64_t hash = cells.size();
  for (const CellId cell : cells) hash = mixed(hash + hashes[cell]);
  return hash;
}

std::uint64_t place_on_curve(const std::array<std::int32_t, 3>& cube) {
  const auto along = [&](std::size_t axis) {
    return spread_to_thirds(static_cast<std::uint32_t>(cube.at(axis) + kFarCube));
  };
  return along(0) | along(1) << 1U | along(2) << 2U;
}

}  // namespace

FacesOfCells::FacesOfCells(const Cells& cells) : offsets_(cells.cells.size() + 1, 0) {
  for (const CellId cell : cells.cell_of_face) ++offsets_[cell + 1];
  std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
  std::vector<std::uint32_t> next(offsets_.begin(), offsets_.end() - 1);
  faces_.resize(cells.cell_of_face.size());
  for (std::uint32_t face = 0; face < faces_.size(); ++face) faces_[next[cells.cell_of_face[face]]++] = face;
}

std::vector<std::uint64_t> hashes_of_cells(const Mesh& mesh, const FacesOfCells& faces, std::size_t cells) {
  constexpr std::size_t kVerticesAtOnce = 4096, kCellsAtOnce = 16;
  std::vector<std::uint64_t> of_vertex(mesh.positions.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, of_vertex.size(), kVerticesAtOnce), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) of_vertex[i] = hash_of(mesh.positions[i]);
  });
  std::vector<std::uint64_t> hashes(cells);
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(cells), kCellsAtOnce),
                    [&](const auto& range) {
                      for (CellId cell{range.begin()}; cell < range.end(); ++cell) {
                        std::uint64_t hash = 0;
                        for (const std::uint32_t face : faces.of(cell)) {
                          const glm::uvec3& corners = mesh.faces[face];
                          const std::uint64_t of_face = of_vertex[corners.x] + 3 * std::rotl(of_vertex[corners.y], 21) +
                                                        5 * std::rotl(of_vertex[corners.z], 42);
                          hash = (std::rotl(hash, 27) ^ of_face) * 0x9e3779b97f4a7c15ull;
                        }
                        hashes[cell] = mixed(hash);
                      }
                    });
  return hashes;
}

std::uint64_t hash_of_chunk(std::span<const CellId> cells, std::span<const CellId> around,
                            std::span<const std::uint64_t> hashes) {
  return hash_of_cells(around, hashes) + 3 * hash_of_cells(cells, hashes);
}

GridChunks::GridChunks(const Surface& surface, double cells_across) : surface_(surface) {
  const std::vector<Cell>& cells = surface.cells.cells;
  side_ = cells_across * surface.cells.size;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;  // cube, cell
  order.reserve(cells.size());
  for (std::uint32_t cell = 0; cell < cells.size(); ++cell) {
    order.emplace_back(place_on_curve(cube_of(cells[cell].centroid)), cell);
    if (!(cells[cell].radius <= side_)) large_cells_.emplace_back(cell);
  }
  std::sort(order.begin(), order.end());
  for (const auto& [cube, cell] : order) {
    if (chunks_.empty() || chunks_.back().cube != cube) chunks_.push_back({cube, {}});
    chunks_.back().cells.emplace_back(cell);
  }
  chunk_of_cube_ = CubeTable(chunks_);
  boxes_.reserve(chunks_.size());
  for (const GridChunk& chunk : chunks_) {
    std::vector<CellId> small = chunk.cells;
    std::erase_if(small, [&](CellId cell) { return !(cells[cell].radius <= side_); });
    boxes_.push_back(box_of(small));
  }
}

GridChunks::CubeTable::CubeTable(const std::vector<GridChunk>& chunks)
    : entries_(std::bit_ceil(2 * chunks.size() + 1), {0, static_cast<std::uint32_t>(chunks.size())}),
      chunks_(static_cast<std::uint32_t>(chunks.size())) {
  for (std::uint32_t chunk = 0; chunk < chunks_; ++chunk) {
    std::size_t i = mixed(chunks[chunk].cube);
    while (entries_[i & (entries_.size() - 1)].chunk != chunks_) ++i;
    entries_[i & (entries_.size() - 1)] = {chunks[chunk].cube, chunk};
  }
}

std::uint32_t GridChunks::CubeTable::find(std::uint64_t cube) const {
  for (std::size_t i = mixed(cube);; ++i) {
    const Entry& entry = entries_[i & (entries_.size() - 1)];
    if (entry.chunk == chunks_ || entry.cube == cube) return entry.chunk;
  }
}

bool GridChunks::are_even() const {
  return large_cells_.size() <= kMostLargeCells;
}

GridChunks::Cube GridChunks::cube_of(const glm::dvec3& place) const {
  Cube cube{};
  for (int axis = 0; axis < 3; ++axis) {
    const double along = std::floor(place[axis] / side_);
    if (std::isnan(along)) continue;
    cube.at(static_cast<std::size_t>(axis)) =
        static_cast<std::int32_t>(std::clamp<double>(along, -kFarCube, kFarCube - 1));
  }
  return cube;
}

GridChunks::Box GridChunks::box_of(std::span<const CellId> cells) const {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Box box{glm::dvec3(kFar), glm::dvec3(-kFar)};
  for (const CellId number : cells) {
    const Cell& cell = surface_.cells.cells[number];
    box.least = glm::min(box.least, cell.centroid - cell.radius);
    box.most = glm::max(box.most, cell.centroid + cell.radius);
  }
  return box;
}

bool GridChunks::are_apart(const Box& a, const Box& b, double distance) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a.least[axis] > b.most[axis] + distance || b.least[axis] > a.most[axis] + distance) return true;
  }
  return false;
}

std::vector<CellId> GridChunks::touching(const Box& box) const {
  const double slack = kRoundingOfSpheres * (glm::distance(box.least, box.most) + glm::length(box.least));
  std::vector<CellId> found;
  const auto touches = [&](CellId number) {
    const Cell& cell = surface_.cells.cells[number];
    const glm::dvec3 nearest = glm::clamp(cell.centroid, box.least, box.most);
    return glm::distance(nearest, cell.centroid) <= cell.radius + slack;
  };
  const auto take_from = [&](std::uint32_t chunk) {
    if (are_apart(boxes_[chunk], box, 2 * slack)) return;
    for (const CellId cell : chunks_[chunk].cells) {
      if (surface_.cells.cells[cell].radius <= side_ && touches(cell)) found.push_back(cell);
    }
  };
  // Cells that are not large reach no farther than a cube's side from their own cube.
  const Cube first = cube_of(box.least - side_), last = cube_of(box.most + side_);
  double cubes = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) cubes *= double{1} + last.at(axis) - first.at(axis);
  if (cubes > static_cast<double>(chunks_.size())) {
    for (std::uint32_t chunk = 0; chunk < chunks_.size(); ++chunk) take_from(chunk);
  } else {
    Cube cube{};
    for (cube[0] = first[0]; cube[0] <= last[0]; ++cube[0]) {
      for (cube[1] = first[1]; cube[1] <= last[1]; ++cube[1]) {
        for (cube[2] = first[2]; cube[2] <= last[2]; ++cube[2]) {
          const std::uint32_t chunk = chunk_of_cube_.find(place_on_curve(cube));
          if (chunk < chunks_.size()) take_from(chunk);
        }
      }
    }
  }
  std::copy_if(large_cells_.begin(), large_cells_.end(), std::back_inserter(found), touches);
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<CellId> GridChunks::around(const GridChunk& chunk, double width) const {
  Box box = box_of(touching(box_of(chunk.cells)));
  box.least -= width;
  box.most += width;
  return touching(box);
}

Surface part_of_cells(const Surface& surface, const FacesOfCells& faces, std::span<const CellId> cells) {
  constexpr std::uint32_t kUnused = ~0u;
  std::vector<std::uint32_t> number_of(surface.mesh.positions.size(), kUnused);
  Surface part;
  part.cells.size = surface.cells.size;
  for (const CellId cell : cells) {
    for (const std::uint32_t face : faces.of(cell)) {
      glm::uvec3 corners = surface.mesh.faces[face];
      for (int corner = 0; corner < 3; ++corner) {
        std::uint32_t& number = number_of[corners[corner]];
        if (number == kUnused) {
          number = static_cast<std::uint32_t>(part.mesh.positions.size());
          part.mesh.positions.push_back(surface.mesh.positions[corners[corner]]);
        }
        corners[corner] = number;
      }
      part.mesh.faces.push_back(corners);
      part.cells.cell_of_face.emplace_back(static_cast<std::uint32_t>(part.cells.cells.size()));
    }
    part.cells.cells.push_back(surface.cells.cells[cell]);
  }
  return part;
}

}  // namespace lumatlas
