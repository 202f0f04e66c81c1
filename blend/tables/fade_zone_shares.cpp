// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/tables/fade_zone_shares.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <map>
#include <optional>
#include <queue>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "mesh/base/number_text.h"
#include "mesh/repair/joined_faces.h"

namespace lumatlas {

namespace {

// Rows of different lengths in one array.
template <typename T>
struct Rows {
  std::vector<std::uint32_t> offsets;
  std::vector<T> values;

  [[nodiscard]] std::span<const T> operator[](std::size_t row) const {
    return std::span(values).subspan(offsets[row], offsets[row + 1] - offsets[row]);
  }
};

// Calls `visit(row, value)` for every pair twice: to count, and to fill.
template <typename T, typename ForEach>
Rows<T> make_rows(std::size_t count, const ForEach& for_each) {
  Rows<T> rows;
  rows.offsets.assign(count + 1, 0);
  for_each([&](std::size_t row, const T&) { ++rows.offsets[row + 1]; });
  for (std::size_t row = 0; row < count; ++row) rows.offsets[row + 1] += rows.offsets[row];
  rows.values.resize(rows.offsets.back());
  std::vector<std::uint32_t> next(rows.offsets.begin(), rows.offsets.end() - 1);
  for_each([&](std::size_t row, const T& value) { rows.values[next[row]++] = value; });
  return rows;
}

// Both neighbours of each corner of each face: an inner edge is listed twice, which costs less than to tell.
Rows<std::uint32_t> vertex_neighbors(const Mesh& mesh) {
  return make_rows<std::uint32_t>(mesh.positions.size(), [&](const auto& visit) {
    for (const glm::uvec3& face : mesh.faces) {
      for (int corner = 0; corner < 3; ++corner) {
        visit(face[corner], face[(corner + 1) % 3]);
        visit(face[corner], face[(corner + 2) % 3]);
      }
    }
  });
}

Rows<std::uint32_t> faces_of_cells(const Cells& cells) {
  return make_rows<std::uint32_t>(cells.cells.size(), [&](const auto& visit) {
    for (std::uint32_t face = 0; face < cells.cell_of_face.size(); ++face) visit(cells.cell_of_face[face], face);
  });
}

struct Share {
  CellId cell;
  double share;  // (0, 1]
};
using VertexShares = std::vector<std::vector<Share>>;  // one per vertex, cells ascending

// Counts the steps of several threads. Whether the limit is exceeded does not depend on the order of the threads.
class StepLimit {
 public:
  explicit StepLimit(std::uint64_t most) : most_(most) {}

  void count(std::uint64_t steps) { taken_.fetch_add(steps, std::memory_order_relaxed); }
  [[nodiscard]] bool exceeded() const { return taken_.load(std::memory_order_relaxed) > most_; }

 private:
  std::uint64_t most_;
  std::atomic<std::uint64_t> taken_ = 0;
};

double edge_length(const Mesh& mesh, std::uint32_t a, std::uint32_t b) {
  return glm::distance(glm::dvec3(mesh.positions[a]), glm::dvec3(mesh.positions[b]));
}

// The vertices within `width` of a cell, nearest first; Dijkstra's algorithm from all of the cell's vertices.
class Expansion {
 public:
  // `neighbors` are vertex_neighbors(mesh); all must outlive this.
  Expansion(const Mesh& mesh, const Rows<std::uint32_t>& neighbors, double width, StepLimit& limit)
      : mesh_(mesh), width_(width), neighbors_(neighbors), limit_(limit), distances_(mesh.positions.size(), kFar) {}

  // Counts the neighbours of every visited vertex as steps. Visits nothing more once their limit is exceeded.
  template <typename Visit>
  void from(std::span<const std::uint32_t> faces, const Visit& visit) {
    for (const std::uint32_t face : faces) {
      for (int corner = 0; corner < 3; ++corner) reach(mesh_.faces[face][corner], 0);
    }
    while (!open_.empty() && !limit_.exceeded()) {
      const auto [distance, vertex] = open_.top();
      open_.pop();
      if (distance > distances_[vertex]) continue;  // reached by a shorter way since
      visit(vertex, distance);
      limit_.count(neighbors_[vertex].size());
      for (const std::uint32_t next : neighbors_[vertex]) {
        const double step = edge_length(mesh_, vertex, next);
        if (distance + step < width_) reach(next, distance + step);
      }
    }
    for (const std::uint32_t vertex : touched_) distances_[vertex] = kFar;
    touched_.clear();
  }

 private:
  static constexpr double kFar = std::numeric_limits<double>::infinity();

  void reach(std::uint32_t vertex, double distance) {
    if (distance >= distances_[vertex]) return;
    if (distances_[vertex] == kFar) touched_.push_back(vertex);
    distances_[vertex] = distance;
    open_.emplace(distance, vertex);
  }

  using Entry = std::pair<double, std::uint32_t>;
  const Mesh& mesh_;
  double width_;
  const Rows<std::uint32_t>& neighbors_;
  StepLimit& limit_;
  std::vector<double> distances_;
  std::vector<std::uint32_t> touched_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open_;
};

struct Reached {
  std::uint32_t vertex;
  double share;
};

// Number of cells that may share a vertex on average, with each of its neighbours counted, before all but the nearest
// are left out. Cells of even size share a vertex with about ten others where the fade is as wide as a cell.
constexpr std::uint64_t kMostCellsPerVertex = 64;
// The number of cells nearest to a vertex that share it then. It is more than a zone holds.
constexpr std::size_t kNearestCells = 2 * kCellsPerZone;

// Returns for each cell the vertices that have a share of it. None if a vertex has more than kMostCellsPerVertex cells
// on average.
std::optional<std::vector<std::vector<Reached>>> vertices_of_cells(const Surface& surface,
                                                                   const Rows<std::uint32_t>& neighbors, double width) {
  const Rows<std::uint32_t> faces = faces_of_cells(surface.cells);
  StepLimit limit(kMostCellsPerVertex * neighbors.values.size());
  tbb::enumerable_thread_specific<Expansion> expansions(
      [&] { return Expansion(surface.mesh, neighbors, width, limit); });
  std::vector<std::vector<Reached>> reached(surface.cells.cells.size());
  tbb::parallel_for(std::size_t{0}, reached.size(), [&](std::size_t cell) {
    if (limit.exceeded()) return;
    expansions.local().from(faces[cell], [&](std::uint32_t vertex, double distance) {
      reached[cell].push_back({vertex, 1 - distance / width});
    });
  });
  if (limit.exceeded()) return std::nullopt;
  return reached;
}

// The shares s_k(v) of only the kNearestCells nearest cells of each vertex, not yet divided by their sum. Dijkstra's
// algorithm from the vertices of all cells at once: the time is bounded by the number of faces, whatever the width is
// and however many cells meet at a vertex.
VertexShares shares_of_nearest_cells(const Surface& surface, const Rows<std::uint32_t>& neighbors, double width) {
  using Entry = std::tuple<double, std::uint32_t, CellId>;  // distance, vertex, cell
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  VertexShares shares(surface.mesh.positions.size());
  const auto takes = [&](std::uint32_t vertex, CellId cell) {
    const std::vector<Share>& of_vertex = shares[vertex];
    return of_vertex.size() < kNearestCells &&
           std::none_of(of_vertex.begin(), of_vertex.end(), [&](const Share& share) { return share.cell == cell; });
  };
  for (std::size_t face = 0; face < surface.mesh.faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      open.emplace(0, surface.mesh.faces[face][corner], surface.cells.cell_of_face[face]);
    }
  }
  while (!open.empty()) {
    const auto [distance, vertex, cell] = open.top();
    open.pop();
    if (!takes(vertex, cell)) continue;
    shares[vertex].push_back({cell, 1 - distance / width});
    for (const std::uint32_t next : neighbors[vertex]) {
      const double there = distance + edge_length(surface.mesh, vertex, next);
      if (there < width && takes(next, cell)) open.emplace(there, next, cell);
    }
  }
  for (std::vector<Share>& of_vertex : shares) {
    std::sort(of_vertex.begin(), of_vertex.end(), [](const Share& a, const Share& b) { return a.cell < b.cell; });
  }
  return shares;
}

// s_k(v), not yet divided by their sum.
VertexShares shares_of_vertices(const Surface& surface, double width) {
  const Rows<std::uint32_t> neighbors = vertex_neighbors(surface.mesh);
  const auto reached = vertices_of_cells(surface, neighbors, width);
  if (!reached) return shares_of_nearest_cells(surface, neighbors, width);
  VertexShares shares(surface.mesh.positions.size());
  for (CellId cell{0}; cell < reached->size(); ++cell) {
    for (const auto& [vertex, share] : (*reached)[cell]) shares[vertex].push_back({cell, share});
  }
  return shares;
}

void normalize(std::vector<Share>& shares) {
  double sum = 0;
  for (const Share& share : shares) sum += share.share;
  for (Share& share : shares) share.share /= sum;
}

// The cells of a face's corners, at most kCellsPerZone of them.
CellShares::Zone zone_of(const glm::uvec3& face, const VertexShares& shares) {
  CellShares::Zone zone{CellId::none, CellId::none, CellId::none, CellId::none};
  std::size_t count = 0;
  for (int corner = 0; corner < 3; ++corner) {
    for (const Share& share : shares[face[corner]]) {
      const auto end = zone.begin() + static_cast<std::ptrdiff_t>(count);
      if (std::find(zone.begin(), end, share.cell) == end) zone.at(count++) = share.cell;
    }
  }
  std::sort(zone.begin(), zone.end());
  return zone;
}

// The same of any face, with the sum of their shares there.
std::map<std::uint32_t, double> cells_at_face(const glm::uvec3& face, const VertexShares& shares) {
  std::map<std::uint32_t, double> cells;
  for (int corner = 0; corner < 3; ++corner) {
    for (const Share& share : shares[face[corner]]) cells[share.cell] += share.share;
  }
  return cells;
}

// Compares by position, so that neither faces nor cells need a certain order.
bool comes_before(const glm::dvec3& a, const glm::dvec3& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

// The cell with the least share of a face, of those that no corner would be left without any cell for. With more than
// three cells there is one.
std::uint32_t least_sharing(const glm::uvec3& face, const VertexShares& shares, const Cells& all,
                            std::map<std::uint32_t, double> cells) {
  for (int corner = 0; corner < 3; ++corner) {
    if (shares[face[corner]].size() == 1) cells.erase(shares[face[corner]].front().cell);
  }
  return std::min_element(cells.begin(), cells.end(),
                          [&](const auto& a, const auto& b) {
                            if (a.second != b.second) return a.second < b.second;
                            return comes_before(all.cells[a.first].centroid, all.cells[b.first].centroid);
                          })
      ->first;
}

// Returns whether more than kCellsPerZone cells share a face.
bool is_overfull(const glm::uvec3& face, const VertexShares& shares) {
  // Most faces have few shares in all, which need not be told apart.
  if (shares[face.x].size() + shares[face.y].size() + shares[face.z].size() <= kCellsPerZone) return false;
  std::array<CellId, kCellsPerZone> cells;
  std::size_t count = 0;
  for (int corner = 0; corner < 3; ++corner) {
    for (const Share& share : shares[face[corner]]) {
      const auto end = cells.begin() + static_cast<std::ptrdiff_t>(count);
      if (std::find(cells.begin(), end, share.cell) != end) continue;
      if (count == kCellsPerZone) return true;
      cells.at(count++) = share.cell;
    }
  }
  return false;
}

std::vector<glm::uvec3> overfull_faces(const Mesh& mesh, const VertexShares& shares) {
  std::vector<std::pair<glm::dvec3, glm::uvec3>> found;  // with three times their centroids
  for (const glm::uvec3& face : mesh.faces) {
    if (!is_overfull(face, shares)) continue;
    found.emplace_back(
        glm::dvec3(mesh.positions[face.x]) + glm::dvec3(mesh.positions[face.y]) + glm::dvec3(mesh.positions[face.z]),
        face);
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return comes_before(a.first, b.first); });
  std::vector<glm::uvec3> faces;
  faces.reserve(found.size());
  for (const auto& [place, face] : found) faces.push_back(face);
  return faces;
}

// Takes cells away from vertices until no face has more than kCellsPerZone.
void limit_cells(const Surface& surface, VertexShares& shares) {
  for (const glm::uvec3& face : overfull_faces(surface.mesh, shares)) {
    std::map<std::uint32_t, double> cells = cells_at_face(face, shares);
    while (cells.size() > kCellsPerZone) {
      const std::uint32_t least = least_sharing(face, shares, surface.cells, cells);
      for (int corner = 0; corner < 3; ++corner) {
        std::erase_if(shares[face[corner]], [&](const Share& share) { return share.cell == least; });
      }
      cells.erase(least);
    }
  }
}

CellShares own_cells(const Cells& cells) {
  CellShares shares;
  for (CellId cell{0}; cell < cells.cells.size(); ++cell) {
    shares.zones.push_back({cell, CellId::none, CellId::none, CellId::none});
  }
  shares.zone_of_face.assign(cells.cell_of_face.begin(), cells.cell_of_face.end());
  const glm::vec4 all(1, 0, 0, 0);
  shares.corners.assign(cells.cell_of_face.size(), {all, all, all});
  return shares;
}

glm::vec4 in_order_of(const CellShares::Zone& zone, const std::vector<Share>& shares) {
  glm::vec4 ordered(0);
  for (const Share& share : shares) {
    const auto found = std::find(zone.begin(), zone.end(), share.cell);
    ordered[static_cast<int>(found - zone.begin())] = static_cast<float>(share.share);
  }
  return ordered;
}

struct ZoneHash {
  std::size_t operator()(const CellShares::Zone& zone) const {
    std::uint64_t hash = 0;
    for (const CellId cell : zone) {
      hash = (hash ^ cell) * 0x9e3779b97f4a7c15ull;
      hash ^= hash >> 32U;
    }
    return hash;
  }
};

// A zone and the zone whose cells stand for its own, with their positions there.
struct JoinedZone {
  CellShares::Zone zone{CellId::none, CellId::none, CellId::none, CellId::none};
  std::array<int, kCellsPerZone> place{};
};

JoinedZone joined_zone(const CellShares::Zone& zone, std::span<const std::uint32_t> stands_for) {
  std::set<CellId> cells;
  for (const CellId cell : zone) {
    if (cell == CellId::none) continue;
    if (cell >= stands_for.size())
      throw std::invalid_argument("cell shares: no cell stands for " + std::to_string(cell));
    cells.emplace(stands_for[cell]);
  }
  JoinedZone result;
  std::copy(cells.begin(), cells.end(), result.zone.begin());
  for (std::size_t i = 0; i < kCellsPerZone && zone.at(i) != CellId::none; ++i) {
    result.place.at(i) = static_cast<int>(std::distance(cells.begin(), cells.find(CellId{stands_for[zone.at(i)]})));
  }
  return result;
}

glm::vec4 joined_shares(const glm::vec4& shares, const std::array<int, kCellsPerZone>& place) {
  glm::vec4 sums(0);
  for (int i = 0; i < static_cast<int>(kCellsPerZone); ++i) sums[place.at(static_cast<std::size_t>(i))] += shares[i];
  return sums;
}

// Shrinks the far sphere so that its cells have the target size of the other cells: the same width then fades them.
void shrink_far_sphere(Surface& surface) {
  if (surface.far_cells == 0) return;
  double area = 0;
  for (std::size_t cell = surface.near_cells(); cell < surface.cells.cells.size(); ++cell) {
    area += surface.cells.cells[cell].area;
  }
  const double scale = surface.cells.size / std::sqrt(area / surface.far_cells);
  if (!(std::isfinite(scale) && scale > 0)) return;  // cells without area, in a file of another program
  std::vector<glm::vec3>& positions = surface.mesh.positions;
  for (std::size_t i = positions.size() - surface.far_vertices; i < positions.size(); ++i) {
    positions[i] *= static_cast<float>(scale);
  }
}

}  // namespace

CellShares share_cells(const Surface& surface, double width) {
  if (!(std::isfinite(width) && width >= 0)) {
    throw std::invalid_argument("cell shares: width is " + number_text(width) + ", must be finite and not negative");
  }
  if (width == 0) return own_cells(surface.cells);
  Surface joined = surface;
  joined.mesh.faces = joined_faces(surface.mesh);
  shrink_far_sphere(joined);
  const Mesh& mesh = joined.mesh;
  VertexShares vertices = shares_of_vertices(joined, width);
  limit_cells(joined, vertices);
  for (std::vector<Share>& shares : vertices) normalize(shares);
  CellShares result;
  std::vector<CellShares::Zone> zones(mesh.faces.size());
  result.corners.resize(mesh.faces.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.faces.size(), 1024), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const glm::uvec3& face = mesh.faces[i];
      zones[i] = zone_of(face, vertices);
      result.corners[i] = {in_order_of(zones[i], vertices[face.x]), in_order_of(zones[i], vertices[face.y]),
                           in_order_of(zones[i], vertices[face.z])};
    }
  });
  std::unordered_map<CellShares::Zone, std::uint32_t, ZoneHash> numbers;
  result.zone_of_face.reserve(zones.size());
  for (std::size_t face = 0; face < zones.size(); ++face) {
    if (face > 0 && zones[face] == zones[face - 1]) {
      result.zone_of_face.push_back(result.zone_of_face.back());
      continue;
    }
    const auto [entry, added] = numbers.emplace(zones[face], static_cast<std::uint32_t>(result.zones.size()));
    if (added) result.zones.push_back(zones[face]);
    result.zone_of_face.push_back(entry->second);
  }
  return result;
}

std::vector<std::uint32_t> first_of_same_references(const ReferenceTable& references) {
  std::map<std::vector<ViewSlot>, std::uint32_t> first;
  std::vector<std::uint32_t> result;
  for (CellId cell{0}; cell + 1 < references.offsets.size(); ++cell) {
    const std::span<const ViewSlot> views = references.of_cell(cell);
    std::vector<ViewSlot> sorted(views.begin(), views.end());
    std::sort(sorted.begin(), sorted.end());
    result.push_back(first.emplace(std::move(sorted), cell).first->second);
  }
  return result;
}

CellShares joined(CellShares shares, std::span<const std::uint32_t> stands_for) {
  std::map<CellShares::Zone, std::uint32_t> numbers;
  std::vector<CellShares::Zone> zones;
  std::vector<std::uint32_t> number_of_zone;
  std::vector<std::array<int, kCellsPerZone>> places;
  for (const CellShares::Zone& zone : shares.zones) {
    const JoinedZone fresh = joined_zone(zone, stands_for);
    const auto [entry, added] = numbers.emplace(fresh.zone, static_cast<std::uint32_t>(zones.size()));
    if (added) zones.push_back(fresh.zone);
    number_of_zone.push_back(entry->second);
    places.push_back(fresh.place);
  }
  for (std::size_t face = 0; face < shares.zone_of_face.size(); ++face) {
    const std::uint32_t zone = shares.zone_of_face[face];
    for (glm::vec4& corner : shares.corners[face]) corner = joined_shares(corner, places[zone]);
    shares.zone_of_face[face] = number_of_zone[zone];
  }
  shares.zones = std::move(zones);
  return shares;
}

CellShares drawn_shares(const Surface& surface, const ReferenceTable& references, double border_width) {
  CellShares shares = share_cells(surface, border_width * surface.cells.size);
  return border_width > 0 ? joined(std::move(shares), first_of_same_references(references)) : shares;
}

}  // namespace lumatlas
