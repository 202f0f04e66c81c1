// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/layout/charts.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/convex_hull_2.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numeric>
#include <span>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include "mesh/base/number_text.h"
#include "mesh/opposite_halfedges.h"
#include "mesh/repair/joined_faces.h"

namespace lumatlas {

namespace {

using glm::dvec2;
using glm::dvec3;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_2;
using FlatFace = std::array<Point, 3>;

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

void require_within(const char* field, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw std::invalid_argument(std::string("charts: ") + field + " is " + number_text(value) + ", must be in [" +
                              number_text(least) + ", " + number_text(most) + "]");
}

// The values of each face that charts need.
struct Faces {
  std::vector<dvec3> area_vectors;               // normal times area, scene units squared
  std::vector<std::array<FaceId, 3>> neighbors;  // across each edge; FaceId::none at a boundary
};

Faces describe(const Mesh& mesh) {
  Faces faces;
  const std::vector<glm::uvec3> joined = joined_faces(mesh);
  const std::vector<std::uint32_t> opposite = opposite_halfedges(mesh.positions.size(), joined);
  faces.area_vectors.resize(mesh.faces.size());
  faces.neighbors.resize(mesh.faces.size());
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const glm::uvec3& f = mesh.faces[i];
    const dvec3 a(mesh.positions[f.x]), b(mesh.positions[f.y]), c(mesh.positions[f.z]);
    faces.area_vectors[i] = 0.5 * glm::cross(b - a, c - a);
    for (std::size_t edge = 0; edge < 3; ++edge) {
      const std::uint32_t other = opposite[3 * i + edge];
      faces.neighbors[i][edge] = other == kNoHalfedge ? FaceId::none : FaceId(other / 3);
    }
  }
  return faces;
}

dvec3 unit_or_zero(const dvec3& v) {
  const double length = glm::length(v);
  return length > 0 ? v / length : dvec3(0);
}

// Cells that share an edge, each pair in both lists; lists ascend.
std::vector<std::vector<CellId>> neighbors_of_cells(const Faces& faces, const Cells& cells) {
  std::vector<std::vector<CellId>> neighbors(cells.cells.size());
  for (std::size_t face = 0; face < faces.neighbors.size(); ++face) {
    const CellId cell = cells.cell_of_face[face];
    for (const FaceId other : faces.neighbors[face]) {
      if (other != FaceId::none && cells.cell_of_face[other] != cell)
        neighbors[cell].push_back(cells.cell_of_face[other]);
    }
  }
  for (auto& list : neighbors) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return neighbors;
}

using FaceGroups = std::vector<std::vector<FaceId>>;

// Faces of neighbouring cells that look about the same way. Groups begin at the largest cells.
FaceGroups group_cells(const Faces& faces, const Cells& cells, const ChartOptions& options) {
  const auto neighbors = neighbors_of_cells(faces, cells);
  const double least_cosine = std::cos(glm::radians(options.merge_degrees));
  std::vector<std::uint32_t> seeds(cells.cells.size());
  std::iota(seeds.begin(), seeds.end(), 0u);
  std::stable_sort(seeds.begin(), seeds.end(),
                   [&](auto a, auto b) { return cells.cells[a].area > cells.cells[b].area; });
  std::vector<std::uint32_t> group_of_cell(cells.cells.size(), kNone);
  std::uint32_t groups = 0;
  std::vector<std::uint32_t> queue;
  for (const std::uint32_t seed : seeds) {
    if (group_of_cell[seed] != kNone) continue;
    const Cell& first = cells.cells[seed];
    dvec3 sum = first.area * first.normal;
    queue.assign(1, seed);
    group_of_cell[seed] = groups;
    for (std::size_t at = 0; at < queue.size(); ++at) {
      for (const std::uint32_t next : neighbors[queue[at]]) {
        const Cell& cell = cells.cells[next];
        if (group_of_cell[next] != kNone) continue;
        if (glm::distance(cell.centroid, first.centroid) > options.reach * cells.size) continue;
        if (glm::dot(cell.normal, unit_or_zero(sum)) < least_cosine) continue;
        if (glm::dot(cell.normal, first.normal) < least_cosine) continue;
        group_of_cell[next] = groups;
        sum += cell.area * cell.normal;
        queue.push_back(next);
      }
    }
    ++groups;
  }
  FaceGroups faces_of_group(groups);
  for (FaceId face{0}; face < cells.cell_of_face.size(); ++face) {
    faces_of_group[group_of_cell[cells.cell_of_face[face]]].push_back(face);
  }
  return faces_of_group;
}

// The same for faces that were left over: neighbouring ones, grown from the first on.
FaceGroups group_faces(const Faces& faces, std::span<const FaceId> left_over, double least_cosine) {
  std::vector<std::uint8_t> is_free(faces.neighbors.size(), 0);
  for (const FaceId face : left_over) is_free[face] = 1;
  FaceGroups groups;
  for (const FaceId seed : left_over) {
    if (!is_free[seed]) continue;
    is_free[seed] = 0;
    std::vector<FaceId> group{seed};
    dvec3 sum = faces.area_vectors[seed];
    for (std::size_t at = 0; at < group.size(); ++at) {
      for (const FaceId next : faces.neighbors[group[at]]) {
        if (next == FaceId::none || !is_free[next]) continue;
        const dvec3 normal = unit_or_zero(faces.area_vectors[next]);
        if (glm::dot(normal, unit_or_zero(sum)) < least_cosine) continue;
        is_free[next] = 0;
        sum += faces.area_vectors[next];
        group.push_back(next);
      }
    }
    groups.push_back(std::move(group));
  }
  return groups;
}

// A unit vector at right angles to a unit vector.
dvec3 across(const dvec3& normal) {
  const dvec3 axis = std::abs(normal.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  return glm::normalize(glm::cross(axis, normal));
}

FlatFace flattened(const Mesh& mesh, FaceId face, const dvec3& right, const dvec3& up) {
  FlatFace flat;
  for (int c = 0; c < 3; ++c) {
    const dvec3 p(mesh.positions[mesh.faces[face][c]]);
    flat[static_cast<std::size_t>(c)] = Point(glm::dot(right, p), glm::dot(up, p));
  }
  return flat;
}

// Returns whether a line along one of a's edges has all of b on its outer side. Both turn counterclockwise.
bool has_separating_edge(const FlatFace& a, const FlatFace& b) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Point& from = a[i];
    const Point& to = a[(i + 1) % 3];
    // Neighbours share corners, for which the predicate would have to compute exactly.
    const auto is_inside = [&](const Point& p) { return p != from && p != to && CGAL::left_turn(from, to, p); };
    if (std::none_of(b.begin(), b.end(), is_inside)) return true;
  }
  return false;
}

// Triangles on a plane whose interiors do not overlap.
class FlatFaces {
 public:
  explicit FlatFaces(double square) : square_(square > 0 ? square : 1) {}

  // Takes a counterclockwise triangle in, unless it would overlap one that is there: then it returns false.
  bool insert(const FlatFace& face) {
    if (covers_many_squares(face)) return insert_large(face);
    const Range range = squares_of(face);
    for (std::int64_t y = range.y0; y <= range.y1; ++y) {
      for (std::int64_t x = range.x0; x <= range.x1; ++x) {
        const auto found = by_square_.find(key(x, y));
        if (found != by_square_.end() && overlaps_any(face, found->second)) return false;
      }
    }
    if (overlaps_any(face, large_)) return false;
    const auto number = static_cast<std::uint32_t>(faces_.size());
    faces_.push_back(face);
    for (std::int64_t y = range.y0; y <= range.y1; ++y) {
      for (std::int64_t x = range.x0; x <= range.x1; ++x) by_square_[key(x, y)].push_back(number);
    }
    return true;
  }

 private:
  struct Range {
    std::int64_t x0, x1, y0, y1;
  };
  // A face that reaches to a stray vertex would fill all memory with its squares: it is compared with every face.
  static constexpr double kMostSquares = 1 << 14;

  [[nodiscard]] bool covers_many_squares(const FlatFace& face) const {
    const auto [x0, x1] = std::minmax({face[0].x(), face[1].x(), face[2].x()});
    const auto [y0, y1] = std::minmax({face[0].y(), face[1].y(), face[2].y()});
    return !(((x1 - x0) / square_ + 1) * ((y1 - y0) / square_ + 1) <= kMostSquares);
  }
  bool insert_large(const FlatFace& face) {
    const auto number = static_cast<std::uint32_t>(faces_.size());
    for (std::uint32_t other = 0; other < number; ++other) {
      if (overlap(face, faces_[other])) return false;
    }
    faces_.push_back(face);
    large_.push_back(number);
    return true;
  }
  static bool overlap(const FlatFace& a, const FlatFace& b) {
    return !has_separating_edge(a, b) && !has_separating_edge(b, a);
  }
  [[nodiscard]] bool overlaps_any(const FlatFace& face, const std::vector<std::uint32_t>& others) const {
    return std::any_of(others.begin(), others.end(), [&](auto other) { return overlap(face, faces_[other]); });
  }
  [[nodiscard]] Range squares_of(const FlatFace& face) const {
    const auto square = [&](double v) { return static_cast<std::int64_t>(std::floor(v / square_)); };
    const auto [x0, x1] = std::minmax({face[0].x(), face[1].x(), face[2].x()});
    const auto [y0, y1] = std::minmax({face[0].y(), face[1].y(), face[2].y()});
    return {square(x0), square(x1), square(y0), square(y1)};
  }
  static std::uint64_t key(std::int64_t x, std::int64_t y) {
    return static_cast<std::uint64_t>(x) << 32 ^ (static_cast<std::uint64_t>(y) & 0xffffffffu);
  }

  double square_;
  std::vector<FlatFace> faces_;
  std::vector<std::uint32_t> large_;  // faces of faces_ that are in no square
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> by_square_;
};

// The faces of a group in the order in which they are reached from its first one over shared edges.
std::vector<FaceId> in_order_of_reach(const Faces& faces, const std::vector<FaceId>& group) {
  std::unordered_map<std::uint32_t, bool> reached;
  reached.reserve(group.size());
  for (const FaceId face : group) reached[face] = false;
  std::vector<FaceId> order;
  order.reserve(group.size());
  const auto reach = [&](FaceId face) {
    const auto found = reached.find(face);
    if (found == reached.end() || found->second) return;
    found->second = true;
    order.push_back(face);
  };
  std::size_t at = 0;
  for (const FaceId seed : group) {
    for (reach(seed); at < order.size(); ++at) {
      for (const FaceId next : faces.neighbors[order[at]]) {
        if (next != FaceId::none) reach(next);
      }
    }
  }
  return order;
}

// The sum of the faces' area vectors, once more without those that look away from it.
dvec3 mean_normal(const Faces& faces, const std::vector<FaceId>& group, double least_cosine) {
  dvec3 sum(0);
  for (const FaceId face : group) sum += faces.area_vectors[face];
  const dvec3 first = unit_or_zero(sum);
  sum = dvec3(0);
  for (const FaceId face : group) {
    if (glm::dot(unit_or_zero(faces.area_vectors[face]), first) >= least_cosine) sum += faces.area_vectors[face];
  }
  const dvec3 normal = unit_or_zero(sum);
  if (glm::length(normal) > 0) return normal;
  const dvec3 of_first = unit_or_zero(faces.area_vectors[group.front()]);
  return glm::length(of_first) > 0 ? of_first : dvec3(0, 0, 1);
}

struct ChartAndRest {
  Chart chart;
  std::vector<FaceId> rest;  // faces that are not in it
};

bool looks_along(const Faces& faces, FaceId face, const dvec3& normal, double least_cosine) {
  const dvec3& area = faces.area_vectors[face];
  return glm::dot(area, normal) >= least_cosine * glm::length(area);
}

// Chooses a group's faces for a chart with the given normal. `right` may be any unit vector at right angles to it.
ChartAndRest choose_faces(const Mesh& mesh, const Faces& faces, const std::vector<FaceId>& group, const dvec3& normal,
                          double least_cosine) {
  ChartAndRest result;
  result.chart.right = across(normal);
  const dvec3 up = glm::cross(normal, result.chart.right);
  result.chart.down = -up;
  double area = 0;
  for (const FaceId face : group) area += glm::length(faces.area_vectors[face]);
  FlatFaces flat(2 * std::sqrt(area / static_cast<double>(group.size())));
  for (const FaceId face : in_order_of_reach(faces, group)) {
    bool fits = looks_along(faces, face, normal, least_cosine);
    if (fits) {
      const FlatFace corners = flattened(mesh, face, result.chart.right, up);
      // A face without area covers nothing, wherever it lies.
      if (CGAL::left_turn(corners[0], corners[1], corners[2])) {
        fits = flat.insert(corners);
      } else if (CGAL::right_turn(corners[0], corners[1], corners[2])) {
        fits = false;
      }
    }
    (fits ? result.chart.faces : result.rest).push_back(face);
  }
  return result;
}

// Turns the chart on its plane so that the rectangle around it is as small as it can be: one of its sides lies along an
// edge of the convex hull.
void turn_and_measure(const Mesh& mesh, Chart& chart) {
  std::vector<Point> points, hull;
  for (const FaceId face : chart.faces) {
    for (const Point& p : flattened(mesh, face, chart.right, chart.down)) points.push_back(p);
  }
  CGAL::convex_hull_2(points.begin(), points.end(), std::back_inserter(hull));
  double least_area = std::numeric_limits<double>::infinity();
  dvec2 least_axis(1, 0);
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Point& p = hull[i];
    const Point& q = hull[(i + 1) % hull.size()];
    const dvec2 edge(q.x() - p.x(), q.y() - p.y());
    const double length = glm::length(edge);
    if (!(length > 0)) continue;
    const dvec2 axis = edge / length;
    dvec2 low(std::numeric_limits<double>::infinity()), high(-std::numeric_limits<double>::infinity());
    for (const Point& h : hull) {
      const dvec2 at(axis.x * h.x() + axis.y * h.y(), -axis.y * h.x() + axis.x * h.y());
      low = glm::min(low, at);
      high = glm::max(high, at);
    }
    const dvec2 size = high - low;
    if (size.x * size.y < least_area) {
      least_area = size.x * size.y;
      least_axis = size.x >= size.y ? axis : dvec2(-axis.y, axis.x);
    }
  }
  const dvec3 right = least_axis.x * chart.right + least_axis.y * chart.down;
  const dvec3 down = -least_axis.y * chart.right + least_axis.x * chart.down;
  chart.right = right;
  chart.down = down;
  dvec2 low(std::numeric_limits<double>::infinity()), high(-std::numeric_limits<double>::infinity());
  chart.least = dvec2(0);
  for (const FaceId face : chart.faces) {
    for (int c = 0; c < 3; ++c) {
      const dvec2 at = chart.place(dvec3(mesh.positions[mesh.faces[face][c]]));
      low = glm::min(low, at);
      high = glm::max(high, at);
    }
  }
  chart.least = low;
  chart.size = high - low;
}

// One chart of a group, and the faces that did not fit; the chart is never empty.
ChartAndRest make_chart(const Mesh& mesh, const Faces& faces, const std::vector<FaceId>& group, double least_cosine) {
  ChartAndRest result = choose_faces(mesh, faces, group, mean_normal(faces, group, least_cosine), least_cosine);
  if (result.chart.faces.empty()) {
    const dvec3 own = unit_or_zero(faces.area_vectors[group.front()]);
    result = choose_faces(mesh, faces, group, glm::length(own) > 0 ? own : dvec3(0, 0, 1), least_cosine);
  }
  if (result.chart.faces.empty()) {  // rounding alone leaves it an area
    result.chart.faces.push_back(result.rest.front());
    result.rest.erase(result.rest.begin());
  }
  turn_and_measure(mesh, result.chart);
  return result;
}

}  // namespace

void check(const ChartOptions& options) {
  require_within("merge_degrees", options.merge_degrees, 0, 80);
  require_within("most_degrees", options.most_degrees, options.merge_degrees, 85);
  require_within("reach", options.reach, 0, 1e6);
}

dvec2 Chart::place(const dvec3& point) const {
  return dvec2(glm::dot(right, point), glm::dot(down, point)) - least;
}

std::vector<Chart> make_charts(const Mesh& mesh, const Cells& cells, const ChartOptions& options) {
  check(options);
  check(mesh);
  if (cells.cell_of_face.size() != mesh.faces.size()) {
    throw std::invalid_argument("charts: cells are of " + std::to_string(cells.cell_of_face.size()) +
                                " faces, must be of the mesh's " + std::to_string(mesh.faces.size()));
  }
  const Faces faces = describe(mesh);
  const double least_cosine = std::cos(glm::radians(options.most_degrees));
  std::vector<Chart> charts;
  FaceGroups groups = group_cells(faces, cells, options);
  while (!groups.empty()) {
    std::vector<ChartAndRest> made(groups.size());
    tbb::parallel_for(std::size_t{0}, groups.size(),
                      [&](std::size_t i) { made[i] = make_chart(mesh, faces, groups[i], least_cosine); });
    std::vector<FaceId> left_over;
    for (ChartAndRest& one : made) {
      charts.push_back(std::move(one.chart));
      left_over.insert(left_over.end(), one.rest.begin(), one.rest.end());
    }
    std::sort(left_over.begin(), left_over.end());
    groups = group_faces(faces, left_over, std::cos(glm::radians(options.merge_degrees + 15)));
  }
  return charts;
}

}  // namespace lumatlas
