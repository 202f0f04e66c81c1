// SPDX-License-Identifier: GPL-3.0-or-later
// Longest-edge bisection: Rivara, "Algorithms for refining triangular grids suitable for adaptive and multigrid
// techniques", 1984. It bounds the smallest angle by half of the smallest one before.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <queue>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "mesh/cells.h"
#include "mesh/face_areas.h"
#include "mesh/halfedge_mesh.h"

namespace lumatlas {

namespace {

double squared_length(const Mesh& mesh, std::uint32_t a, std::uint32_t b) {
  const glm::dvec3 edge = glm::dvec3(mesh.positions[a]) - glm::dvec3(mesh.positions[b]);
  return glm::dot(edge, edge);
}

double squared_longest_edge(const Mesh& mesh, const glm::uvec3& face) {
  return std::max({squared_length(mesh, face.x, face.y), squared_length(mesh, face.y, face.z),
                   squared_length(mesh, face.z, face.x)});
}

// No triangle with edges up to m has more area than the equilateral one, and a strip needs a face for every m of it.
double fewest_faces_after(const Mesh& mesh, double max_edge) {
  const double largest_area = std::sqrt(3.0) / 4 * max_edge * max_edge;
  const std::vector<double> areas = face_areas(mesh);
  double faces = 0;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const double along_edge = std::sqrt(squared_longest_edge(mesh, mesh.faces[i])) / max_edge;
    faces += std::max({1.0, along_edge, areas[i] / largest_area});
  }
  return faces;
}

// The distance of neighbouring floats where they lie furthest apart in this mesh.
double resolution_of_long_faces(const Mesh& mesh, double max_edge) {
  float largest = 0;
  for (const glm::uvec3& face : mesh.faces) {
    if (!(squared_longest_edge(mesh, face) > max_edge * max_edge)) continue;
    for (int corner = 0; corner < 3; ++corner) {
      const glm::vec3& p = mesh.positions[face[corner]];
      largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    }
  }
  return static_cast<double>(std::nextafter(largest, std::numeric_limits<float>::infinity())) - largest;
}

[[noreturn]] void refuse(double max_edge, const std::string& rule) {
  std::ostringstream message;
  message << "max_edge: is " << max_edge << ", must be " << rule;
  throw std::invalid_argument(message.str());
}

// Below the first limit halving an edge may not shorten it; the second is far beyond what any later stage can hold.
void check_feasible(const Mesh& mesh, double max_edge) {
  constexpr double kMostFaces = 5e8;
  const double least = 4 * resolution_of_long_faces(mesh, max_edge);
  std::ostringstream rule;
  if (!(max_edge >= least)) {
    rule << "at least " << least << ", four times the resolution of the positions of the faces to be split";
    refuse(max_edge, rule.str());
  }
  const double faces = fewest_faces_after(mesh, max_edge);
  if (!(faces <= kMostFaces)) {
    rule << "larger: it would split the mesh into at least " << faces << " faces, the limit is " << kMostFaces;
    refuse(max_edge, rule.str());
  }
}

double squared_length(const HalfedgeMesh& mesh, OpenMesh::SmartEdgeHandle edge) {
  const auto a = OpenMesh::vector_cast<OpenMesh::Vec3d>(mesh.point(edge.v0()));
  const auto b = OpenMesh::vector_cast<OpenMesh::Vec3d>(mesh.point(edge.v1()));
  return (a - b).sqrnorm();
}

// Longest first, then by index: an order that depends on the mesh alone. An edge changes only when it is split, so that
// what the queue says of an edge stays true.
class LongEdges {
 public:
  LongEdges(const HalfedgeMesh& mesh, double max_edge) : mesh_(mesh), max_squared_(max_edge * max_edge) {
    for (const auto edge : mesh.edges()) add_if_long(edge);
  }
  void add_if_long(OpenMesh::SmartEdgeHandle edge) {
    const double squared = squared_length(mesh_, edge);
    if (squared > max_squared_) queue_.emplace(squared, -edge.idx());
  }
  [[nodiscard]] bool empty() const { return queue_.empty(); }
  [[nodiscard]] OpenMesh::SmartEdgeHandle take() {
    const int index = -queue_.top().second;
    queue_.pop();
    return OpenMesh::make_smart(OpenMesh::EdgeHandle(index), mesh_);
  }

 private:
  const HalfedgeMesh& mesh_;
  double max_squared_;
  std::priority_queue<std::pair<double, int>> queue_;
};

OpenMesh::SmartVertexHandle halve(HalfedgeMesh& mesh, OpenMesh::SmartEdgeHandle edge) {
  const auto a = edge.v0();
  const auto b = edge.v1();
  const auto color = (mesh.color(a) + mesh.color(b)) * 0.5f;
  // Halved before they are added: the sum of two large floats may overflow.
  const auto middle = mesh.add_vertex(mesh.point(a) * 0.5f + mesh.point(b) * 0.5f);
  mesh.set_color(middle, color);
  mesh.split(edge, middle);
  return middle;
}

bool has_long_edge(const Mesh& mesh, double max_edge) {
  return std::any_of(mesh.faces.begin(), mesh.faces.end(),
                     [&](const glm::uvec3& face) { return squared_longest_edge(mesh, face) > max_edge * max_edge; });
}

}  // namespace

Mesh split_large_faces(const Mesh& mesh, double max_edge) {
  if (!(max_edge > 0)) refuse(max_edge, "above 0");
  if (!has_long_edge(mesh, max_edge)) return mesh;
  check_feasible(mesh, max_edge);
  HalfedgeMesh halfedge_mesh = to_halfedge_mesh(mesh);
  LongEdges long_edges(halfedge_mesh, max_edge);
  while (!long_edges.empty()) {
    const auto middle = halve(halfedge_mesh, long_edges.take());
    for (const auto edge : middle.edges()) long_edges.add_if_long(edge);
  }
  return from_halfedge_mesh(halfedge_mesh, !mesh.colors.empty());
}

}  // namespace lumatlas
