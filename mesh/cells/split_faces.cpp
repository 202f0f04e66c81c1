// SPDX-License-Identifier: GPL-3.0-or-later
// Longest-edge bisection: Rivara, "Algorithms for refining triangular grids suitable for adaptive and multigrid
// techniques", 1984. It bounds the smallest angle by half of the smallest one before.
#include "mesh/cells/split_faces.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <queue>
#include <span>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "mesh/face_geometry.h"
#include "mesh/halfedge_mesh.h"

namespace lumatlas {

namespace {

constexpr double kBytesAFace = 400;  // halfedges, the queue and the returned mesh
constexpr double kMemoryShare = 0.5;
constexpr double kMostFacesOfAMesh = 5e8;  // see mesh.h
constexpr double kHeadroom = 4;            // most faces that halving may make for each one that the area asks for

// A needle is more than this many times as long as high.
constexpr double kNeedle = 20;
constexpr double kLongestNeedle = 1000;  // in max_edge; a scene is some 60 cells across
constexpr std::uint32_t kMostNeedleHalvings = 1'000'000;

bool is_needle(double squared_longest_edge, double area) {
  return squared_longest_edge > kNeedle * 2 * area;  // the height is twice the area over the longest edge
}

double squared_length(const Mesh& mesh, std::uint32_t a, std::uint32_t b) {
  const glm::dvec3 edge = glm::dvec3(mesh.positions[a]) - glm::dvec3(mesh.positions[b]);
  return glm::dot(edge, edge);
}

double squared_longest_edge(const Mesh& mesh, const glm::uvec3& face) {
  return std::max({squared_length(mesh, face.x, face.y), squared_length(mesh, face.y, face.z),
                   squared_length(mesh, face.z, face.x)});
}

// The size of the work, known before it begins.
struct Forecast {
  bool any_long = false;         // faces to be split
  double fewest_faces = 0;       // that their area becomes: none with edges up to m has more than the equilateral one
  double other_faces = 0;        // that stay whole
  float largest_coordinate = 0;  // the largest of their corners
};

Forecast forecast(const Mesh& mesh, std::span<const FaceGeometry> geometry, double max_edge) {
  const double largest_area = std::sqrt(3.0) / 4 * max_edge * max_edge;
  Forecast result;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const glm::uvec3& face = mesh.faces[i];
    const double squared = squared_longest_edge(mesh, face);
    const double longest = kLongestNeedle * max_edge;
    if (!(squared > max_edge * max_edge) || (squared > longest * longest && is_needle(squared, geometry[i].area))) {
      ++result.other_faces;
      continue;
    }
    result.any_long = true;
    result.fewest_faces += std::max(1.0, geometry[i].area / largest_area);
    for (int corner = 0; corner < 3; ++corner) {
      const glm::vec3& p = mesh.positions[face[corner]];
      result.largest_coordinate = std::max({result.largest_coordinate, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    }
  }
  return result;
}

[[noreturn]] void refuse(double max_edge, const std::string& rule) {
  std::ostringstream message;
  message << "max_edge: is " << max_edge << ", must be " << rule;
  throw std::invalid_argument(message.str());
}

// Returns how many faces the memory of this machine holds while they are split.
double most_faces() {
  const auto memory = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  return std::min(kMostFacesOfAMesh, kMemoryShare * memory / kBytesAFace);
}

[[noreturn]] void refuse_count(double max_edge, double faces, double limit) {
  std::ostringstream rule;
  rule << "larger: it would split the mesh into at least " << faces << " faces, and this machine has memory for "
       << limit;
  refuse(max_edge, rule.str());
}

void check_edge(double max_edge) {
  if (!(max_edge > 0) || std::isinf(max_edge)) refuse(max_edge, "finite and above 0");
}

void check_feasible(const Forecast& forecast, double max_edge) {
  const float next = std::nextafter(forecast.largest_coordinate, std::numeric_limits<float>::infinity());
  const double resolution = static_cast<double>(next) - forecast.largest_coordinate;
  // Below this, halving an edge may not shorten it.
  if (!(max_edge >= 4 * resolution)) {
    std::ostringstream rule;
    rule << "at least " << 4 * resolution << ", four times the resolution of the positions of the faces to be split";
    refuse(max_edge, rule.str());
  }
  const double limit = most_faces() / kHeadroom;
  if (!(forecast.fewest_faces <= limit)) refuse_count(max_edge, forecast.fewest_faces, limit);
}

OpenMesh::Vec3d point(const HalfedgeMesh& mesh, OpenMesh::SmartVertexHandle vertex) {
  return OpenMesh::vector_cast<OpenMesh::Vec3d>(mesh.point(OpenMesh::VertexHandle(vertex.idx())));
}

// Halves edges, longest first and then by index: an order that depends on the mesh alone. An edge changes only when it
// is split, so that what the queue says of an edge stays true.
class EdgeHalving {
 public:
  EdgeHalving(HalfedgeMesh& mesh, double max_edge)
      : mesh_(mesh), max_edge_(max_edge), most_faces_(static_cast<double>(mesh.n_faces()) + most_faces()) {
    for (const auto edge : mesh.edges()) enqueue_if_long(edge);
  }

  void run(const CancelCheck& cancel_check) {
    constexpr std::uint32_t kBetweenChecks = 1024;
    for (std::uint32_t taken = 0; !queue_.empty(); ++taken) {
      if (cancel_check && taken % kBetweenChecks == 0) cancel_check();
      const auto [squared, negated_index] = queue_.top();
      queue_.pop();
      const auto edge = OpenMesh::make_smart(OpenMesh::EdgeHandle(-negated_index), mesh_);
      if (is_between_needles(edge, squared) && !may_halve_needles(squared)) continue;
      for (const auto part : halve(edge).edges()) enqueue_if_long(part);
      if (static_cast<double>(mesh_.n_faces()) > most_faces_) {
        refuse_count(max_edge_, static_cast<double>(mesh_.n_faces()), most_faces_);
      }
    }
  }

 private:
  void enqueue_if_long(OpenMesh::SmartEdgeHandle edge) {
    const double squared = (point(mesh_, edge.v0()) - point(mesh_, edge.v1())).sqrnorm();
    if (squared > max_edge_ * max_edge_) queue_.emplace(squared, -edge.idx());
  }

  // `edge` is the longest of the faces beside it, for longer ones have had their turn.
  [[nodiscard]] bool is_between_needles(OpenMesh::SmartEdgeHandle edge, double squared) const {
    for (const auto halfedge : {edge.h0(), edge.h1()}) {
      if (halfedge.is_boundary()) continue;
      const OpenMesh::Vec3d from = point(mesh_, halfedge.from());
      const OpenMesh::Vec3d along = point(mesh_, halfedge.to()) - from;
      const OpenMesh::Vec3d across = point(mesh_, halfedge.next().to()) - from;
      if (!is_needle(squared, along.cross(across).norm() / 2)) return false;
    }
    return true;
  }

  [[nodiscard]] bool may_halve_needles(double squared) {
    const double longest = kLongestNeedle * max_edge_;
    if (squared > longest * longest || needle_halvings_ == kMostNeedleHalvings) return false;
    ++needle_halvings_;
    return true;
  }

  OpenMesh::SmartVertexHandle halve(OpenMesh::SmartEdgeHandle edge) {
    const OpenMesh::VertexHandle a(edge.v0().idx()), b(edge.v1().idx());
    const auto color = (mesh_.color(a) + mesh_.color(b)) * 0.5f;
    // Halved before they are added: the sum of two large floats may overflow.
    const OpenMesh::VertexHandle middle(mesh_.add_vertex(mesh_.point(a) * 0.5f + mesh_.point(b) * 0.5f).idx());
    mesh_.set_color(middle, color);
    mesh_.split(OpenMesh::EdgeHandle(edge.idx()), middle);
    return OpenMesh::make_smart(middle, mesh_);
  }

  HalfedgeMesh& mesh_;
  double max_edge_;
  double most_faces_;
  std::priority_queue<std::pair<double, int>> queue_;
  std::uint32_t needle_halvings_ = 0;
};

}  // namespace

Mesh split_large_faces(const Mesh& mesh, double max_edge, const CancelCheck& cancel_check) {
  check_edge(max_edge);
  check(mesh);
  const Forecast expected = forecast(mesh, face_geometry(mesh), max_edge);
  if (!expected.any_long) return mesh;
  check_feasible(expected, max_edge);
  HalfedgeMesh halfedge_mesh = to_halfedge_mesh(mesh);
  EdgeHalving(halfedge_mesh, max_edge).run(cancel_check);
  return from_halfedge_mesh(halfedge_mesh, !mesh.colors.empty());
}

double fewest_split_faces(const Mesh& mesh, double max_edge) {
  check_edge(max_edge);
  check(mesh);
  const Forecast expected = forecast(mesh, face_geometry(mesh), max_edge);
  return expected.fewest_faces + expected.other_faces;
}

}  // namespace lumatlas
