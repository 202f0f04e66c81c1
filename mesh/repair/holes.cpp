// SPDX-License-Identifier: GPL-3.0-or-later
// Source: P. Liepa, "Filling holes in meshes", 2003, as CGAL has it.
#include "mesh/repair/holes.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/utility.h>

#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <compare>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "mesh/base/number_text.h"
#include "mesh/readers/polygons.h"
#include "mesh/vertex_faces.h"

namespace lumatlas {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Loop = std::vector<std::uint32_t>;  // vertices, in the direction that the faces of a patch have along it

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
// Most vertices of a loop that is filled by the best of all triangles where a Delaunay triangulation does not fill it.
// Time grows with the cube of their number.
constexpr std::size_t kMostForAllTriangles = 250;
// A larger loop is filled by triangles of a Delaunay triangulation alone. CGAL may look at this number of its edges for
// each edge of the loop: it looks at some six where the triangulation has the loop's edges, and at as many as the loop
// has where it has not.
constexpr std::size_t kMostEdgesLookedAt = 10;
constexpr std::size_t kMostForDelaunay = 3000;  // vertices of a loop; the depth of CGAL's recursion grows with them
constexpr std::size_t kStepsBetweenChecks = 256;
constexpr double kRimShare = 0.5;  // a loop of at least this share of its component's diagonal is the component's rim

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return std::uint64_t{std::max(a, b)} << 32 | std::min(a, b);
}

double diagonal(const Bounds& box) {
  return box.empty() ? 0 : glm::length(box.max - box.min);
}

// The other ends of the edges at a vertex along which the surface ends, for the faces that run towards it. It ends
// where no other face runs the other way, and where an edge has more than two.
class BoundaryEdges {
 public:
  explicit BoundaryEdges(const Mesh& mesh) : mesh_(mesh), around_(mesh.positions.size(), mesh.faces) {}

  // Good until the next call.
  [[nodiscard]] const std::vector<std::uint32_t>& towards(std::uint32_t vertex) {
    uses_.clear();
    for (const std::uint32_t face : around_[vertex]) {
      const glm::uvec3& corners = mesh_.faces[face];
      for (int i = 0; i < 3; ++i) {
        const std::uint32_t from = corners[i], to = corners[(i + 1) % 3];
        if (to == vertex) uses_.push_back({from, true});
        if (from == vertex) uses_.push_back({to, false});
      }
    }
    std::sort(uses_.begin(), uses_.end());
    ends_.clear();
    for (auto first = uses_.begin(); first != uses_.end();) {
      const auto last = std::find_if(first, uses_.end(), [&](const Use& use) { return use.other != first->other; });
      const auto towards = std::count_if(first, last, [](const Use& use) { return use.towards; });
      const bool is_inside = last - first == 2 && towards == 1;
      if (!is_inside) ends_.insert(ends_.end(), static_cast<std::size_t>(towards), first->other);
      first = last;
    }
    return ends_;
  }

 private:
  struct Use {
    std::uint32_t other;
    bool towards;
    auto operator<=>(const Use&) const = default;
  };
  const Mesh& mesh_;
  VertexFaces around_;
  std::vector<Use> uses_;
  std::vector<std::uint32_t> ends_;
};

// Returns for each boundary vertex the vertex before it along the faces' direction; kNone where there is no boundary or
// more than one.
std::vector<std::uint32_t> boundary_before(const Mesh& mesh) {
  BoundaryEdges edges(mesh);
  std::vector<std::uint32_t> before(mesh.positions.size(), kNone);
  for (std::uint32_t vertex = 0; vertex < before.size(); ++vertex) {
    const std::vector<std::uint32_t>& from = edges.towards(vertex);
    if (from.size() == 1) before[vertex] = from.front();
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

double size_of(const Mesh& mesh, const Loop& loop) {
  Bounds box;
  for (const std::uint32_t vertex : loop) box = with(box, glm::dvec3(mesh.positions[vertex]));
  return diagonal(box);
}

// Returns for each loop the diagonal of the box around the component that the loop is in, scene units.
std::vector<double> component_diagonals(const Mesh& mesh, const std::vector<Loop>& loops) {
  const std::size_t count = mesh.positions.size();
  std::vector<std::uint8_t> rank(count, 0);
  std::vector<std::uint32_t> parent(count);
  boost::disjoint_sets<std::uint8_t*, std::uint32_t*> sets(rank.data(), parent.data());
  for (std::uint32_t vertex = 0; vertex < count; ++vertex) sets.make_set(vertex);
  for (const glm::uvec3& face : mesh.faces) {
    sets.union_set(face.x, face.y);
    sets.union_set(face.y, face.z);
  }
  std::unordered_map<std::uint32_t, Bounds> boxes;
  for (const Loop& loop : loops) boxes[sets.find_set(loop.front())];
  for (std::uint32_t vertex = 0; vertex < count; ++vertex) {
    const auto found = boxes.find(sets.find_set(vertex));
    if (found != boxes.end()) found->second = with(found->second, glm::dvec3(mesh.positions[vertex]));
  }
  std::vector<double> diagonals;
  diagonals.reserve(loops.size());
  for (const Loop& loop : loops) diagonals.push_back(diagonal(boxes[sets.find_set(loop.front())]));
  return diagonals;
}

bool has_area(const Mesh& mesh, const glm::uvec3& face) {
  const glm::dvec3 a(mesh.positions[face.x]), b(mesh.positions[face.y]), c(mesh.positions[face.z]);
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  return glm::dot(normal, normal) > 0;
}

struct TakesTooLong {};

// Follows CGAL's steps, so that the cancel check may end them, and ends them itself where they are too many. CGAL
// copies it.
struct FillingSteps : CGAL::Polygon_mesh_processing::Hole_filling::Default_visitor {
  FillingSteps(const CancelCheck& called, CancelCheckEvery& among_many, std::size_t& left)
      : cancel_check(called), checks(&among_many), steps_left(&left) {}
  void quadratic_step() const {  // an edge of the Delaunay triangulation, and all triangles at it
    check_cancelled(cancel_check);
    if ((*steps_left)-- == 0) throw TakesTooLong();
  }
  void cubic_step() const { checks->step(); }  // one triangle
  const CancelCheck& cancel_check;
  CancelCheckEvery* checks;
  std::size_t* steps_left;
};

// The faces, as indices into the loop, that are best by CGAL's measures; none where it finds none, or is not tried
// because it would take too long.
std::vector<glm::uvec3> best_faces(const std::vector<glm::dvec3>& positions, const CancelCheck& cancel_check) {
  if (positions.size() > kMostForDelaunay) return {};
  const bool is_small = positions.size() <= kMostForAllTriangles;
  std::vector<Kernel::Point_3> points;
  points.reserve(positions.size());
  for (const glm::dvec3& position : positions) points.emplace_back(position.x, position.y, position.z);
  using Triangle = CGAL::Triple<int, int, int>;
  std::vector<Triangle> triangles;
  CancelCheckEvery checks(cancel_check, kStepsBetweenChecks);
  std::size_t left = is_small ? std::numeric_limits<std::size_t>::max() : kMostEdgesLookedAt * positions.size();
  FillingSteps steps(cancel_check, checks, left);
  try {
    CGAL::Polygon_mesh_processing::triangulate_hole_polyline(
        points, std::back_inserter(triangles),
        CGAL::parameters::do_not_use_cubic_algorithm(!is_small).visitor(std::ref(steps)));
  } catch (const TakesTooLong&) {
    return {};
  }
  // All triangles turn as one; that beside the first edge of the loop tells which way.
  bool along = false;
  for (const Triangle& t : triangles) {
    along =
        along || (t.first == 0 && t.second == 1) || (t.second == 0 && t.third == 1) || (t.third == 0 && t.first == 1);
  }
  std::vector<glm::uvec3> faces;
  for (const Triangle& t : triangles) {
    faces.push_back(along ? glm::uvec3(t.first, t.second, t.third) : glm::uvec3(t.first, t.third, t.second));
  }
  return faces;
}

// Returns the best faces that fill a loop, or, where there are none, those of the loop as it is seen along an axis.
std::vector<glm::uvec3> faces_within(const std::vector<glm::dvec3>& positions, const CancelCheck& cancel_check) {
  std::vector<glm::uvec3> faces = best_faces(positions, cancel_check);
  if (faces.size() == positions.size() - 2) return faces;
  std::vector<std::uint32_t> corners(positions.size());
  std::iota(corners.begin(), corners.end(), 0u);
  return triangulated(std::move(corners), positions).value_or(std::vector<glm::uvec3>());
}

using Edges = std::unordered_set<std::uint64_t>;

// Returns nothing if there is no patch that the mesh can take.
std::optional<std::vector<glm::uvec3>> patch_for(const Mesh& mesh, const Loop& loop, const Edges& edges,
                                                 const CancelCheck& cancel_check) {
  std::vector<glm::dvec3> positions;
  positions.reserve(loop.size());
  for (const std::uint32_t vertex : loop) positions.emplace_back(mesh.positions[vertex]);
  std::vector<glm::uvec3> patch = faces_within(positions, cancel_check);
  if (patch.size() != loop.size() - 2) return std::nullopt;
  for (glm::uvec3& face : patch) {
    face = {loop[face.x], loop[face.y], loop[face.z]};
    if (!has_area(mesh, face)) return std::nullopt;
  }
  Edges around;
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
  std::erase_if(loops, [&](const Loop& loop) { return size_of(mesh, loop) > largest; });
  if (loops.empty()) return loops;
  const std::vector<double> diagonals = component_diagonals(mesh, loops);
  std::size_t index = 0;
  std::erase_if(loops, [&](const Loop& loop) { return size_of(mesh, loop) >= kRimShare * diagonals[index++]; });
  return loops;
}

// Returns the edges of the mesh between two vertices of the loops: only these may a patch have too.
Edges edges_between(const Mesh& mesh, const std::vector<Loop>& loops) {
  std::vector<bool> on_loop(mesh.positions.size(), false);
  for (const Loop& loop : loops) {
    for (const std::uint32_t vertex : loop) on_loop[vertex] = true;
  }
  Edges edges;
  for (const glm::uvec3& face : mesh.faces) {
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = face[i], b = face[(i + 1) % 3];
      if (on_loop[a] && on_loop[b]) edges.insert(edge_key(a, b));
    }
  }
  return edges;
}

}  // namespace

ClosedHoles close_holes(const Mesh& mesh, double largest, const CancelCheck& cancel_check) {
  if (!(std::isfinite(largest) && largest >= 0)) {
    throw std::invalid_argument("holes: largest is " + number_text(largest) + ", must be finite and not negative");
  }
  check(mesh);
  ClosedHoles closed;
  const std::vector<Loop> loops = largest > 0 ? small_loops(mesh, largest) : std::vector<Loop>();
  Edges edges = edges_between(mesh, loops);
  std::vector<glm::uvec3> added;
  for (const Loop& loop : loops) {
    check_cancelled(cancel_check);
    const auto patch = patch_for(mesh, loop, edges, cancel_check);
    if (!patch) continue;
    for (const glm::uvec3& face : *patch) {
      for (int i = 0; i < 3; ++i) edges.insert(edge_key(face[i], face[(i + 1) % 3]));
    }
    added.insert(added.end(), patch->begin(), patch->end());
    ++closed.holes;
  }
  closed.faces = added.size();
  closed.mesh.positions = mesh.positions;
  closed.mesh.colors = mesh.colors;
  closed.mesh.faces.reserve(mesh.faces.size() + added.size());
  closed.mesh.faces.insert(closed.mesh.faces.end(), mesh.faces.begin(), mesh.faces.end());
  closed.mesh.faces.insert(closed.mesh.faces.end(), added.begin(), added.end());
  return closed;
}

}  // namespace lumatlas
