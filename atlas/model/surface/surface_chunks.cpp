// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/surface/surface_chunks.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <utility>

#include "atlas/model/surface/written_mesh.h"

namespace lumatlas {

namespace {

using CellList = std::vector<CellId>;

int longest_axis(const Cells& cells, const CellList& part) {
  glm::dvec3 least(std::numeric_limits<double>::infinity()), most(-least);
  for (const CellId cell : part) {
    least = glm::min(least, cells.cells[cell].centroid);
    most = glm::max(most, cells.cells[cell].centroid);
  }
  const glm::dvec3 extent = most - least;
  int axis = 0;
  for (int other = 1; other < 3; ++other) axis = extent[other] > extent[axis] ? other : axis;
  return axis;
}

std::size_t faces_of(const std::vector<std::size_t>& faces, const CellList& part) {
  std::size_t sum = 0;
  for (const CellId cell : part) sum += faces[cell];
  return sum;
}

// Halves a part of several cells, so that both halves have about as many faces.
std::pair<CellList, CellList> halves(const Cells& cells, const std::vector<std::size_t>& faces, CellList part) {
  const int axis = longest_axis(cells, part);
  std::sort(part.begin(), part.end(), [&](CellId a, CellId b) {
    const double at_a = cells.cells[a].centroid[axis], at_b = cells.cells[b].centroid[axis];
    return at_a != at_b ? at_a < at_b : a < b;
  });
  const std::size_t half = faces_of(faces, part) / 2;
  std::size_t count = 1, sum = faces[part.front()];
  while (count + 1 < part.size() && sum + faces[part[count]] <= half) sum += faces[part[count++]];
  const auto middle = part.begin() + static_cast<std::ptrdiff_t>(count);
  return {CellList(part.begin(), middle), CellList(middle, part.end())};
}

// Returns whether a coordinate that is stored less `origin` is the same again.
bool is_exact(float coordinate, double origin) {
  const auto stored = static_cast<float>(static_cast<double>(coordinate) - origin);
  const double again = static_cast<double>(stored) + origin;
  return again == static_cast<double>(coordinate) &&
         std::bit_cast<std::uint32_t>(static_cast<float>(again)) == std::bit_cast<std::uint32_t>(coordinate);
}

double exact_coordinate(const std::vector<glm::vec3>& positions, int axis) {
  if (positions.empty()) return 0;
  float least = positions.front()[axis], most = least;
  for (const glm::vec3& position : positions) {
    least = std::min(least, position[axis]);
    most = std::max(most, position[axis]);
  }
  const double extent = static_cast<double>(most) - static_cast<double>(least);
  const double middle = 0.5 * (static_cast<double>(least) + static_cast<double>(most));
  // A number of few bits: the middle to a quarter of the extent.
  const double step = extent > 0 ? std::exp2(std::floor(std::log2(extent)) - 2) : 0;
  const double origin = step > 0 ? std::round(middle / step) * step : static_cast<double>(least);
  const bool exact = std::isfinite(origin) && std::all_of(positions.begin(), positions.end(), [&](const glm::vec3& p) {
                       return is_exact(p[axis], origin);
                     });
  return exact ? origin : 0;
}

template <typename T, typename Numbers>
std::vector<T> picked(const std::vector<T>& values, const Numbers& numbers) {
  std::vector<T> result;
  result.reserve(numbers.size());
  for (const std::uint32_t number : numbers) result.push_back(values[number]);
  return result;
}

}  // namespace

std::vector<CellList> cells_of_chunks(const Surface& surface, std::size_t most_faces) {
  std::vector<std::size_t> faces(surface.near_cells(), 0);
  for (std::size_t face = 0; face < surface.near_faces(); ++face) ++faces[surface.cells.cell_of_face[face]];
  CellList all;
  for (std::size_t cell = 0; cell < faces.size(); ++cell) all.emplace_back(static_cast<std::uint32_t>(cell));
  std::vector<CellList> open{std::move(all)}, chunks;
  while (!open.empty()) {
    CellList part = std::move(open.back());
    open.pop_back();
    if (part.size() < 2 || faces_of(faces, part) <= most_faces) {
      std::sort(part.begin(), part.end());
      chunks.push_back(std::move(part));
      continue;
    }
    auto [first, second] = halves(surface.cells, faces, std::move(part));
    open.push_back(std::move(second));
    open.push_back(std::move(first));
  }
  return chunks;
}

glm::dvec3 exact_origin(const std::vector<glm::vec3>& positions) {
  return {exact_coordinate(positions, 0), exact_coordinate(positions, 1), exact_coordinate(positions, 2)};
}

Mesh placed_mesh(const SurfaceChunk& chunk) {
  Mesh mesh = near_surface(*chunk.snapshot.surface).mesh;
  for (glm::vec3& position : mesh.positions) {
    for (int axis = 0; axis < 3; ++axis) {
      if (chunk.origin[axis] == 0) continue;
      position[axis] = static_cast<float>(static_cast<double>(position[axis]) + chunk.origin[axis]);
    }
  }
  const std::vector<glm::u8vec3>& colors = chunk.snapshot.vertex_colors.get();
  mesh.colors.assign(colors.begin(), colors.begin() + static_cast<std::ptrdiff_t>(mesh.positions.size()));
  return mesh;
}

ChunkMaker::ChunkMaker(const Snapshot& snapshot, const CellShares* shares, const TexturePlaces* places,
                       std::size_t most_faces, std::optional<double> grid)
    : ChunkMaker(snapshot, shares, places, cells_of_chunks(*snapshot.surface, most_faces), grid) {}

ChunkMaker::ChunkMaker(const Snapshot& snapshot, const CellShares* shares, const TexturePlaces* places,
                       std::vector<std::vector<CellId>> cells, std::optional<double> grid)
    : snapshot_(snapshot),
      shares_(shares),
      places_(places),
      cells_(std::move(cells)),
      chunk_of_cell_(snapshot.surface->near_cells(), 0),
      number_in_chunk_(snapshot.surface->near_cells(), 0) {
  const Surface& surface = *snapshot.surface;
  for (std::size_t chunk = 0; chunk < cells_.size(); ++chunk) {
    for (std::size_t i = 0; i < cells_[chunk].size(); ++i) {
      chunk_of_cell_[cells_[chunk][i]] = static_cast<std::uint32_t>(chunk);
      number_in_chunk_[cells_[chunk][i]] = static_cast<std::uint32_t>(i);
    }
  }
  const std::size_t vertices = surface.mesh.positions.size() - surface.far_vertices;
  VertexSplit split =
      split_vertices(std::span(surface.mesh.faces).first(surface.near_faces()), vertices,
                     [&](std::size_t face, int) { return std::uint32_t{surface.cells.cell_of_face[face]}; });
  near_.faces = std::move(split.faces);
  near_.positions = picked(surface.mesh.positions, split.source);
  sources_ = std::move(split.source);
  faces_of_chunk_.resize(count());
  for (std::uint32_t face = 0; face < near_.faces.size(); ++face) {
    faces_of_chunk_[chunk_of_cell_[surface.cells.cell_of_face[face]]].push_back(face);
  }
  vertices_of_chunk_.resize(count());
  for (std::uint32_t vertex = 0; vertex < near_.positions.size(); ++vertex) {
    // A vertex without a face counts as one of cell 0, which a surface without faces lacks.
    const std::uint32_t cell = split.values[vertex];
    std::vector<std::uint32_t>& of_chunk = vertices_of_chunk_[chunk_of_cell_.empty() ? 0 : chunk_of_cell_[cell]];
    number_of_vertex_.push_back(static_cast<std::uint32_t>(of_chunk.size()));
    of_chunk.push_back(vertex);
  }
  if (grid && count() > 1) snap_to_grid(near_.positions, *grid);
}

// Fills the chunk's numbers, and returns its surface without the far sphere.
Surface ChunkMaker::near_part(SurfaceChunk& chunk, std::size_t number) const {
  const Cells& all = snapshot_.surface->cells;
  chunk.cells.assign(cells_[number].begin(), cells_[number].end());
  chunk.vertices = vertices_of_chunk_[number];
  chunk.faces = faces_of_chunk_[number];
  Surface part;
  for (const std::uint32_t face : chunk.faces) {
    const glm::uvec3& corners = near_.faces[face];
    part.mesh.faces.emplace_back(number_of_vertex_[corners.x], number_of_vertex_[corners.y],
                                 number_of_vertex_[corners.z]);
    part.cells.cell_of_face.emplace_back(number_in_chunk_[all.cell_of_face[face]]);
  }
  part.mesh.positions = picked(near_.positions, chunk.vertices);
  part.cells.size = all.size;
  part.cells.cells = picked(all.cells, chunk.cells);
  part.offset = snapshot_.surface->offset;
  return part;
}

// Cuts the shares to the chunk's faces, and lists the guest cells.
void ChunkMaker::add_guests(SurfaceChunk& chunk) const {
  if (!shares_) return;
  const Surface& surface = *snapshot_.surface;
  std::vector<std::uint32_t> faces = chunk.faces;
  std::vector<std::uint32_t>& guests = chunk.guests;
  for (std::size_t face = 0; face < chunk.snapshot.surface->far_faces; ++face) {
    faces.push_back(static_cast<std::uint32_t>(surface.near_faces() + face));
  }
  CellShares shares;
  shares.corners = picked(shares_->corners, faces);
  std::vector<std::uint32_t> zone_number(shares_->zones.size(), CellId::none);
  for (const std::uint32_t face : faces) {
    std::uint32_t& zone = zone_number[shares_->zone_of_face[face]];
    if (zone == CellId::none) {
      zone = static_cast<std::uint32_t>(shares.zones.size());
      shares.zones.push_back(shares_->zones[shares_->zone_of_face[face]]);
    }
    shares.zone_of_face.push_back(zone);
  }
  const std::size_t chunk_number = chunk.cells.empty() ? 0 : chunk_of_cell_[chunk.cells.front()];
  const auto is_guest = [&](CellId cell) {
    return cell < surface.near_cells() && chunk_of_cell_[cell] != chunk_number;
  };
  for (const CellShares::Zone& zone : shares.zones) {
    for (const CellId cell : zone) {
      if (cell != CellId::none && is_guest(cell)) guests.push_back(cell);
    }
  }
  std::sort(guests.begin(), guests.end());
  guests.erase(std::unique(guests.begin(), guests.end()), guests.end());
  const std::size_t own = chunk.snapshot.surface->cells.cells.size();
  for (CellShares::Zone& zone : shares.zones) {
    for (CellId& cell : zone) {
      if (cell == CellId::none) continue;
      if (cell >= surface.near_cells()) {
        cell = CellId(static_cast<std::uint32_t>(chunk.cells.size() + (cell - surface.near_cells())));
      } else if (is_guest(cell)) {
        const auto guest = std::lower_bound(guests.begin(), guests.end(), std::uint32_t{cell}) - guests.begin();
        cell = CellId(static_cast<std::uint32_t>(own + static_cast<std::size_t>(guest)));
      } else {
        cell = CellId(number_in_chunk_[cell]);
      }
    }
  }
  chunk.shares = std::move(shares);
}

void ChunkMaker::add_tables(SurfaceChunk& chunk) const {
  const Surface& surface = *snapshot_.surface;
  Snapshot& part = chunk.snapshot;
  std::vector<std::uint32_t> cells = chunk.cells;
  for (std::size_t cell = 0; cell < part.surface->far_cells; ++cell) {
    cells.push_back(static_cast<std::uint32_t>(surface.near_cells() + cell));
  }
  part.cell_seen = picked(snapshot_.cell_seen, cells);
  if (!snapshot_.cell_coverage.empty()) part.cell_coverage = picked(snapshot_.cell_coverage, cells);
  if (!snapshot_.cell_deviation.empty()) part.cell_deviation = picked(snapshot_.cell_deviation, cells);
  cells.insert(cells.end(), chunk.guests.begin(), chunk.guests.end());
  part.references = {};
  for (const std::uint32_t cell : cells) {
    const auto views = snapshot_.references.of_cell(cell);
    part.references.views.insert(part.references.views.end(), views.begin(), views.end());
    part.references.offsets.push_back(static_cast<std::uint32_t>(part.references.views.size()));
  }
}

SurfaceChunk ChunkMaker::chunk(std::size_t number) const {
  const Surface& surface = *snapshot_.surface;
  SurfaceChunk chunk;
  Surface part = near_part(chunk, number);
  if (count() > 1) chunk.origin = exact_origin(part.mesh.positions);
  for (glm::vec3& position : part.mesh.positions) {
    for (int axis = 0; axis < 3; ++axis) {
      if (chunk.origin[axis] == 0) continue;  // the sign of a zero stays
      position[axis] = static_cast<float>(static_cast<double>(position[axis]) - chunk.origin[axis]);
    }
  }
  const std::vector<glm::u8vec3>& all_colors = snapshot_.vertex_colors.get();
  std::vector<glm::u8vec3> colors;
  for (const std::uint32_t vertex : chunk.vertices) colors.push_back(all_colors[sources_[vertex]]);
  if (number == 0 && surface.far_faces > 0) {
    part = with_far_sphere(part, far_sphere_of(surface));
    colors.insert(colors.end(), all_colors.end() - surface.far_vertices, all_colors.end());
  }
  chunk.snapshot.views = snapshot_.views;
  chunk.snapshot.gains = snapshot_.gains;
  chunk.snapshot.tiles = snapshot_.tiles;
  chunk.snapshot.vertex_colors = std::move(colors);
  chunk.snapshot.surface = std::make_shared<const Surface>(std::move(part));
  add_guests(chunk);
  add_tables(chunk);
  if (places_) chunk.places = picked(*places_, chunk.faces);
  return chunk;
}

}  // namespace lumatlas
