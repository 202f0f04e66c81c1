// SPDX-License-Identifier: GPL-3.0-or-later
// Source: P. Liepa, "Filling holes in meshes", 2003, as CGAL has it.
#include "mesh/holes.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/utility.h>

#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <unordered_set>
#include <utility>
#include <vector>

#include "mesh/base/number_text.h"
#include "mesh/opposite_halfedges.h"

namespace lumatlas {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Loop = std::vector<std::uint32_t>;  // vertices, in the direction that the faces of a patch have along it

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr double kRimShare = 0.5;  // of its component's diagonal, from which on a loop is taken for its rim

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return std::uint64_t{std::max(a, b)} << 32 | std::min(a, b);
}

Bounds with(const Bounds& box, const glm::dvec3& point) {
  return box.empty() ? Bounds{point, point} : Bounds{glm::min(box.min, point), glm::max(box.max, point)};
}

double diagonal(const Bounds& box) {
  return box.empty() ? 0 : glm::length(box.max - box.min);
}

// Where the surface ends, by vertex: the vertex before it along the faces' direction, kNone where there is no boundary
// or more than one.
std::vector<std::uint32_t> boundary_before(const Mesh& mesh) {
  const std::vector<std::uint32_t> opposite = opposite_halfedges(mesh.positions.size(), mesh.faces);
  std::vector<std::uint32_t> before(mesh.positions.size(), kNone);
  std::vector<std::uint8_t> branches(mesh.positions.size(), 0);
  for (std::size_t halfedge = 0; halfedge < opposite.size(); ++halfedge) {
    if (opposite[halfedge] != kNoHalfedge) continue;
    const glm::uvec3& face = mesh.faces[halfedge / 3];
    const std::uint32_t from = face[static_cast<int>(halfedge % 3)];
    const std::uint32_t to = face[static_cast<int>((halfedge + 1) % 3)];
    if (before[to] != kNone) branches[to] = 1;
    before[to] = from;
  }
  for (std::size_t vertex = 0; vertex < before.size(); ++vertex) {
    if (branches[vertex]) before[vertex] = kNone;
  }
  return before;
}

// Closed ones alone. A patch runs along the boundary against the faces that end there.
std::vector<Loop> boundary_loops(const Mesh& mesh) {
  const std::vector<std::uint32_t> before = boundary_before(mesh);
  std::vector<std::uint8_t> visited(before.size(), 0);
  std::vector<Loop> loops;
  for (std::uint32_t start = 0; start < before.size(); ++start) {
    Loop loop;
    std::uint32_t vertex = start;
    while (vertex != kNone && !visited[vertex] && before[vertex] != kNone) {
      visited[vertex] = 1;
      loop.push_back(vertex);
      vertex = before[vertex];
    }
    if (loop.size() >= 3 && vertex == start) loops.push_back(std::move(loop));
  }
  return loops;
}

// By vertex, the diagonal of the box of all that is connected with it.
std::vector<double> component_diagonals(const Mesh& mesh) {
  const std::size_t count = mesh.positions.size();
  std::vector<std::uint32_t> rank(count, 0), parent(count);
  boost::disjoint_sets<std::uint32_t*, std::uint32_t*> sets(rank.data(), parent.data());
  for (std::uint32_t vertex = 0; vertex < count; ++vertex) sets.make_set(vertex);
  for (const glm::uvec3& face : mesh.faces) {
    sets.union_set(face.x, face.y);
    sets.union_set(face.y, face.z);
  }
  std::vector<Bounds> boxes(count);
  for (std::uint32_t vertex = 0; vertex < count; ++vertex) {
    Bounds& box = boxes[sets.find_set(vertex)];
    box = with(box, glm::dvec3(mesh.positions[vertex]));
  }
  std::vector<double> diagonals(count);
  for (std::uint32_t vertex = 0; vertex < count; ++vertex) diagonals[vertex] = diagonal(boxes[sets.find_set(vertex)]);
  return diagonals;
}

bool has_area(const Mesh& mesh, const glm::uvec3& face) {
  const glm::dvec3 a(mesh.positions[face.x]), b(mesh.positions[face.y]), c(mesh.positions[face.z]);
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  return glm::dot(normal, normal) > 0;
}

// None where there is no patch that the mesh can take.
std::optional<std::vector<glm::uvec3>> patch_for(const Mesh& mesh, const Loop& loop,
                                                 const std::unordered_set<std::uint64_t>& edges) {
  std::vector<Kernel::Point_3> points;
  points.reserve(loop.size());
  for (const std::uint32_t vertex : loop) {
    const glm::vec3& position = mesh.positions[vertex];
    points.emplace_back(position.x, position.y, position.z);
  }
  using Triangle = CGAL::Triple<int, int, int>;
  std::vector<Triangle> triangles;
  CGAL::Polygon_mesh_processing::triangulate_hole_polyline(points, std::back_inserter(triangles));
  if (triangles.size() != loop.size() - 2) return std::nullopt;
  // All triangles turn as one; that beside the first edge of the loop tells which way.
  bool along = false;
  for (const Triangle& t : triangles) {
    along =
        along || (t.first == 0 && t.second == 1) || (t.second == 0 && t.third == 1) || (t.third == 0 && t.first == 1);
  }
  std::vector<glm::uvec3> patch;
  for (const Triangle& t : triangles) {
    const auto corner = [&](int i) { return loop[static_cast<std::size_t>(i)]; };
    const glm::uvec3 face = along ? glm::uvec3(corner(t.first), corner(t.second), corner(t.third))
                                  : glm::uvec3(corner(t.first), corner(t.third), corner(t.second));
    if (!has_area(mesh, face)) return std::nullopt;
    patch.push_back(face);
  }
  std::unordered_set<std::uint64_t> around;
  for (std::size_t i = 0; i < loop.size(); ++i) around.insert(edge_key(loop[i], loop[(i + 1) % loop.size()]));
  for (const glm::uvec3& face : patch) {
    for (int i = 0; i < 3; ++i) {
      const std::uint64_t edge = edge_key(face[i], face[(i + 1) % 3]);
      if (!around.contains(edge) && edges.contains(edge)) return std::nullopt;
    }
  }
  return patch;
}

std::vector<Loop> small_loops(const Mesh& mesh, double largest) {
  std::vector<Loop> loops = boundary_loops(mesh);
  const std::vector<double> diagonals = component_diagonals(mesh);
  std::erase_if(loops, [&](const Loop& loop) {
    Bounds box;
    for (const std::uint32_t vertex : loop) box = with(box, glm::dvec3(mesh.positions[vertex]));
    const double size = diagonal(box);
    return size > largest || size >= kRimShare * diagonals[loop.front()];
  });
  return loops;
}

}  // namespace

ClosedHoles close_holes(const Mesh& mesh, double largest, const Tick& tick) {
  if (!(std::isfinite(largest) && largest >= 0)) {
    throw std::invalid_argument("holes: largest is " + number_text(largest) + ", must be finite and not negative");
  }
  check(mesh);
  ClosedHoles closed{mesh, 0, 0};
  if (largest == 0) return closed;
  const std::vector<Loop> loops = small_loops(mesh, largest);
  if (loops.empty()) return closed;
  std::unordered_set<std::uint64_t> edges;
  for (const glm::uvec3& face : mesh.faces) {
    for (int i = 0; i < 3; ++i) edges.insert(edge_key(face[i], face[(i + 1) % 3]));
  }
  for (const Loop& loop : loops) {
    if (tick) tick();
    const auto patch = patch_for(mesh, loop, edges);
    if (!patch) continue;
    for (const glm::uvec3& face : *patch) {
      closed.mesh.faces.push_back(face);
      for (int i = 0; i < 3; ++i) edges.insert(edge_key(face[i], face[(i + 1) % 3]));
    }
    ++closed.holes;
    closed.faces += patch->size();
  }
  return closed;
}

}  // namespace lumatlas
