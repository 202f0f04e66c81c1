// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/repair.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/finite.h"
#include "mesh/repair/manifold_check.h"
#include "mesh/repair/manifold_repair.h"
#include "mesh/vertex_faces.h"

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
  std::vector<std::uint32_t> copies;  // for each number past the last point, the point that it copies
  std::vector<Face> faces;
};

void check(const TriangleSoup& soup, const glm::dvec3& offset) {
  constexpr std::size_t kMost = 500'000'000;  // also the limit of a Mesh
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

// The hashes that more than one point has, ascending. None only if all positions differ.
std::vector<std::uint64_t> repeated_hashes(const std::vector<SourcePoint>& points) {
  std::vector<std::uint64_t> hashes(points.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size()), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) hashes[i] = hash_of(points[i]);
  });
  tbb::parallel_sort(hashes);
  std::size_t kept = 0;
  for (std::size_t i = 1; i < hashes.size(); ++i) {
    const bool is_kept = kept > 0 && hashes[kept - 1] == hashes[i];
    if (hashes[i] == hashes[i - 1] && !is_kept) hashes[kept++] = hashes[i];
  }
  hashes.resize(kept);
  hashes.shrink_to_fit();
  return hashes;
}

// The points that may have the position of another, so sorted that those at one position are neighbours, ascending by
// index.
std::vector<std::uint32_t> suspected_of_repeating(const std::vector<SourcePoint>& points,
                                                  const std::vector<std::uint64_t>& hashes) {
  std::vector<std::uint32_t> suspects;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (std::binary_search(hashes.begin(), hashes.end(), hash_of(points[i]))) suspects.push_back(i);
  }
  tbb::parallel_sort(suspects.begin(), suspects.end(), [&](std::uint32_t a, std::uint32_t b) {
    const Kernel::Point_3 &p = points[a], &q = points[b];
    return std::tuple(p.x(), p.y(), p.z(), a) < std::tuple(q.x(), q.y(), q.z(), b);
  });
  return suspects;
}

// Every point at the position of an earlier one gives way to the first; the others keep their order.
void merge_vertices(WorkingSoup& work, RepairReport& report) {
  std::vector<SourcePoint>& points = work.points;
  const std::vector<std::uint64_t> hashes = repeated_hashes(points);
  if (hashes.empty()) return;
  constexpr std::uint32_t kFirst = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> now(points.size(), kFirst);  // the first point at its position, or kFirst: it is that one
  const std::vector<std::uint32_t> suspects = suspected_of_repeating(points, hashes);
  for (std::size_t i = 1, first = 0; i < suspects.size(); ++i) {
    if (points[suspects[i]] == points[suspects[first]]) {
      now[suspects[i]] = suspects[first];
    } else {
      first = i;
    }
  }
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (now[i] == kFirst) {
      points[kept] = points[i];
      now[i] = kept++;
    } else {
      now[i] = now[now[i]];
    }
  }
  report.merged_vertices = points.size() - kept;
  points.resize(kept);
  for (Face& face : work.faces) {
    for (std::uint32_t& vertex : face) vertex = now[vertex];
  }
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

// Returns whether the soup was an oriented manifold all along.
bool drop_duplicates(WorkingSoup& work, RepairReport& report) {
  const VertexFaces around(work.points.size(), work.faces);
  const std::vector<std::uint32_t> suspects = vertices_without_one_fan(work.points.size(), work.faces, around);
  if (suspects.empty()) return true;
  report.duplicate_faces = drop_duplicate_faces(work.faces, around, suspects);
  return false;
}

void orient(WorkingSoup& work, RepairReport& report) {
  const VertexFaces around(work.points.size(), work.faces);
  const std::vector<std::uint32_t> suspects = vertices_without_one_fan(work.points.size(), work.faces, around);
  OrientedFaces oriented = orient_and_split(work.points.size(), work.faces, around, suspects);
  work.copies = std::move(oriented.copies);
  report.non_manifold_edges = oriented.non_manifold_edges;
  report.non_manifold_vertices = oriented.split_vertices;
  report.reversed_faces = oriented.reversed_faces;
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
  const std::size_t vertices = work.points.size() + work.copies.size();
  const auto point = [&](std::size_t vertex) -> const SourcePoint& {
    return work.points[vertex < work.points.size() ? vertex : work.copies[vertex - work.points.size()]];
  };
  mesh.positions.reserve(vertices);
  for (std::size_t i = 0; i < vertices; ++i) mesh.positions.emplace_back(point(i).x(), point(i).y(), point(i).z());
  if (!soup.colors.empty()) {
    mesh.colors.reserve(vertices);
    for (std::size_t i = 0; i < vertices; ++i) mesh.colors.push_back(soup.colors[point(i).source]);
  }
  mesh.faces.reserve(work.faces.size());
  for (const Face& face : work.faces) mesh.faces.emplace_back(face[0], face[1], face[2]);
  return mesh;
}

}  // namespace

RepairedMesh repair(const TriangleSoup& soup, const glm::dvec3& offset, const CancelCheck& cancel_check) {
  const auto between_steps = [&] { check_cancelled(cancel_check); };
  check(soup, offset);
  RepairReport report;
  WorkingSoup work = finite_part(soup, offset, report);
  between_steps();
  merge_vertices(work, report);
  between_steps();
  drop_degenerate_faces(work, report);
  require_faces(soup, work, report);
  between_steps();
  const bool is_clean = drop_duplicates(work, report);
  between_steps();
  report.isolated_vertices = PMP::remove_isolated_points_in_polygon_soup(work.points, work.faces);
  between_steps();
  if (!is_clean) orient(work, report);
  between_steps();
  return {to_mesh(work, soup), report};
}

}  // namespace lumatlas
