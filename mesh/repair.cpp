// SPDX-License-Identifier: GPL-3.0-or-later
// The steps are CGAL's for polygon soups; orienting and splitting follow
// Gueziec et al., "Cutting and Stitching: Converting Sets of Polygons to Manifold Surfaces", 2001.
#include "mesh/repair.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <bit>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/fans.h"
#include "mesh/finite.h"

namespace lumatlas {

namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Face = std::array<std::uint32_t, 3>;

// CGAL merges, moves and copies points as values, so that the source's index goes where the point goes.
struct SourcePoint : Kernel::Point_3 {
  SourcePoint() = default;
  SourcePoint(const glm::vec3& p, std::uint32_t index) : Kernel::Point_3(p.x, p.y, p.z), source(index) {}
  std::uint32_t source = 0;  // into the soup's vertices
};

struct WorkingSoup {
  std::vector<SourcePoint> points;
  std::vector<Face> faces;
};

void check(const TriangleSoup& soup, const glm::dvec3& offset) {
  constexpr std::size_t kMost = 500'000'000;  // of a Mesh too
  const std::size_t vertices = soup.positions.size();
  if (vertices > kMost || soup.faces.size() > kMost) {
    throw std::invalid_argument("soup: has " + std::to_string(vertices) + " positions and " +
                                std::to_string(soup.faces.size()) + " faces, must have at most " +
                                std::to_string(kMost) + " of each");
  }
  if (!soup.colors.empty() && soup.colors.size() != vertices) {
    throw std::invalid_argument("soup: has " + std::to_string(soup.colors.size()) +
                                " colors, must be none or one for each of its " + std::to_string(vertices) +
                                " positions");
  }
  for (std::size_t face = 0; face < soup.faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = soup.faces[face][corner];
      if (vertex < vertices) continue;
      throw std::invalid_argument("soup: face " + std::to_string(face) + " refers to position " +
                                  std::to_string(vertex) + ", must be below " + std::to_string(vertices));
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (std::isfinite(offset[axis])) continue;
    throw std::invalid_argument("offset: coordinate " + std::to_string(axis) + " is " + std::to_string(offset[axis]) +
                                ", must be finite");
  }
}

WorkingSoup finite_part(const TriangleSoup& soup, const glm::dvec3& offset, RepairReport& report) {
  constexpr std::uint32_t kDropped = std::numeric_limits<std::uint32_t>::max();
  WorkingSoup work;
  work.points.reserve(soup.positions.size());
  std::vector<std::uint32_t> kept_as(soup.positions.size(), kDropped);
  for (std::uint32_t vertex = 0; vertex < soup.positions.size(); ++vertex) {
    const glm::vec3 position(soup.positions[vertex] - offset);
    if (!is_finite(position)) continue;
    kept_as[vertex] = static_cast<std::uint32_t>(work.points.size());
    work.points.emplace_back(position, vertex);
  }
  work.faces.reserve(soup.faces.size());
  for (const glm::uvec3& face : soup.faces) {
    const Face kept{kept_as[face.x], kept_as[face.y], kept_as[face.z]};
    if (std::find(kept.begin(), kept.end(), kDropped) == kept.end()) work.faces.push_back(kept);
  }
  report.non_finite_vertices = soup.positions.size() - work.points.size();
  report.non_finite_faces = soup.faces.size() - work.faces.size();
  return work;
}

std::uint64_t hash_of(const Kernel::Point_3& point) {
  std::uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis) {
    hash ^= std::bit_cast<std::uint64_t>(point[axis] + 0.0);  // -0 and 0 are one position
    hash *= 0x9e3779b97f4a7c15ull;
    hash ^= hash >> 32;
  }
  return hash;
}

// False only if all positions differ; a collision of hashes costs no more than time.
bool may_repeat_positions(const std::vector<SourcePoint>& points) {
  std::vector<std::uint64_t> hashes(points.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size()), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) hashes[i] = hash_of(points[i]);
  });
  tbb::parallel_sort(hashes);
  return std::adjacent_find(hashes.begin(), hashes.end()) != hashes.end();
}

void merge_vertices(WorkingSoup& work, RepairReport& report) {
  if (!may_repeat_positions(work.points)) return;
  report.merged_vertices = PMP::merge_duplicate_points_in_polygon_soup(work.points, work.faces);
}

bool is_degenerate(const WorkingSoup& work, const Face& face) {
  if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) return true;
  const Kernel::Point_3& a = work.points[face[0]];
  const Kernel::Point_3& b = work.points[face[1]];
  const Kernel::Point_3& c = work.points[face[2]];
  return Kernel().collinear_3_object()(a, b, c);
}

void drop_degenerate_faces(WorkingSoup& work, RepairReport& report) {
  std::vector<std::uint8_t> degenerate(work.faces.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, work.faces.size()), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) degenerate[i] = is_degenerate(work, work.faces[i]);
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < work.faces.size(); ++i) {
    if (!degenerate[i]) work.faces[kept++] = work.faces[i];
  }
  report.degenerate_faces = work.faces.size() - kept;
  work.faces.resize(kept);
}

// What orient_polygon_soup found and did. It copies its visitor, and reports an edge once for each of its faces.
struct OrientationLog {
  std::set<std::pair<std::size_t, std::size_t>> non_manifold_edges;
  std::uint64_t non_manifold_vertices = 0;
  std::vector<std::uint8_t> reversed;  // per face
};

struct OrientationVisitor : PMP::Default_orientation_visitor {
  explicit OrientationVisitor(OrientationLog& target) : log(&target) {}
  void non_manifold_edge(std::size_t a, std::size_t b, std::size_t) const {
    log->non_manifold_edges.insert(std::minmax(a, b));
  }
  void non_manifold_vertex(std::size_t, std::size_t) const { ++log->non_manifold_vertices; }
  void polygon_orientation_reversed(std::size_t face) const { log->reversed[face] ^= 1; }
  OrientationLog* log;
};

// CGAL keeps the orientation of a component's first face; turns round the components where most faces had the other.
void keep_majority_orientation(WorkingSoup& work, std::vector<std::uint8_t>& reversed) {
  boost::disjoint_sets_with_storage<> components(work.points.size());
  for (const Face& face : work.faces) {
    components.union_set(face[0], face[1]);
    components.union_set(face[0], face[2]);
  }
  std::vector<std::int64_t> surplus(work.points.size(), 0);  // reversed faces less the others, at the representative
  for (std::size_t i = 0; i < work.faces.size(); ++i) {
    surplus[components.find_set(work.faces[i][0])] += reversed[i] ? 1 : -1;
  }
  for (std::size_t i = 0; i < work.faces.size(); ++i) {
    if (surplus[components.find_set(work.faces[i][0])] <= 0) continue;
    std::reverse(work.faces[i].begin(), work.faces[i].end());
    reversed[i] ^= 1;
  }
}

void orient(WorkingSoup& work, RepairReport& report) {
  OrientationLog log;
  log.reversed.assign(work.faces.size(), 0);
  PMP::orient_polygon_soup(work.points, work.faces, CGAL::parameters::visitor(OrientationVisitor(log)));
  const auto is_set = [](std::uint8_t flag) { return flag != 0; };
  if (std::any_of(log.reversed.begin(), log.reversed.end(), is_set)) keep_majority_orientation(work, log.reversed);
  report.non_manifold_edges = log.non_manifold_edges.size();
  report.non_manifold_vertices = log.non_manifold_vertices;
  report.reversed_faces = std::count_if(log.reversed.begin(), log.reversed.end(), is_set);
}

void require_faces(const TriangleSoup& soup, const WorkingSoup& work, const RepairReport& report) {
  if (!work.faces.empty()) return;
  if (soup.faces.empty()) throw InputError("the mesh has no faces");
  throw InputError("the mesh has no usable face: of its " + std::to_string(soup.faces.size()) + " faces, " +
                   std::to_string(report.degenerate_faces) + " are degenerate and " +
                   std::to_string(report.non_finite_faces) + " have a corner that is not finite");
}

Mesh to_mesh(const WorkingSoup& work, const TriangleSoup& soup) {
  Mesh mesh;
  mesh.positions.reserve(work.points.size());
  for (const SourcePoint& point : work.points) mesh.positions.emplace_back(point.x(), point.y(), point.z());
  if (!soup.colors.empty()) {
    mesh.colors.reserve(work.points.size());
    for (const SourcePoint& point : work.points) mesh.colors.push_back(soup.colors[point.source]);
  }
  mesh.faces.reserve(work.faces.size());
  for (const Face& face : work.faces) mesh.faces.emplace_back(face[0], face[1], face[2]);
  return mesh;
}

}  // namespace

RepairedMesh repair(const TriangleSoup& soup, const glm::dvec3& offset, const Tick& tick) {
  const auto between_steps = [&] {
    if (tick) tick();
  };
  check(soup, offset);
  RepairReport report;
  WorkingSoup work = finite_part(soup, offset, report);
  between_steps();
  merge_vertices(work, report);
  between_steps();
  drop_degenerate_faces(work, report);
  require_faces(soup, work, report);
  between_steps();
  // The costly steps change nothing in an oriented manifold.
  const bool is_clean = is_oriented_manifold(work.points.size(), work.faces);
  if (!is_clean) report.duplicate_faces = PMP::merge_duplicate_polygons_in_polygon_soup(work.points, work.faces);
  between_steps();
  report.isolated_vertices = PMP::remove_isolated_points_in_polygon_soup(work.points, work.faces);
  between_steps();
  if (!is_clean) orient(work, report);
  between_steps();
  return {to_mesh(work, soup), report};
}

}  // namespace lumatlas
