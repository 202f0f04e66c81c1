// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/face_graph.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "mesh/vertex_faces.h"

namespace lumatlas {

namespace {

template <typename Body>
void for_each_face(std::size_t faces, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, faces, 1024), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
  });
}

bool has_vertex(const glm::uvec3& face, std::uint32_t vertex) {
  return face.x == vertex || face.y == vertex || face.z == vertex;
}

// The one other face at an edge; kNoNeighbor if there are none or several.
std::uint32_t across(const Mesh& mesh, const VertexFaces& around, std::uint32_t face, std::uint32_t a,
                     std::uint32_t b) {
  std::uint32_t found = kNoNeighbor;
  for (const std::uint32_t other : around[a]) {
    if (other == face || !has_vertex(mesh.faces[other], b)) continue;
    if (found != kNoNeighbor) return kNoNeighbor;
    found = other;
  }
  return found;
}

void connect(FaceGraph& graph, const Mesh& mesh) {
  const VertexFaces around(mesh.positions.size(), mesh.faces);
  for_each_face(mesh.faces.size(), [&](std::size_t i) {
    const glm::uvec3& face = mesh.faces[i];
    const auto index = static_cast<std::uint32_t>(i);
    graph[i].neighbors = {across(mesh, around, index, face.x, face.y), across(mesh, around, index, face.y, face.z),
                          across(mesh, around, index, face.z, face.x)};
  });
}

glm::vec3 unit_or_zero(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0 ? glm::vec3(v / length) : glm::vec3(0);
}

void measure(FaceGraph& graph, const Mesh& mesh, const std::vector<double>& areas) {
  graph.resize(mesh.faces.size());
  for_each_face(mesh.faces.size(), [&](std::size_t i) {
    const glm::uvec3& face = mesh.faces[i];
    const glm::dvec3 a(mesh.positions[face.x]);
    const glm::dvec3 b(mesh.positions[face.y]);
    const glm::dvec3 c(mesh.positions[face.z]);
    graph[i].area = static_cast<float>(areas[i]);
    graph[i].centroid = (a + b + c) / 3.0;
    graph[i].normal = unit_or_zero(glm::cross(b - a, c - a));
  });
}

// Each pass carries a normal to the next neighbours; after k passes it has reached about sqrt(k) of them.
void smooth_normals(FaceGraph& graph, double radius) {
  constexpr int kPasses = 8;
  std::vector<glm::vec3> smoothed(graph.size());
  for (int pass = 0; pass < kPasses; ++pass) {
    for_each_face(graph.size(), [&](std::size_t i) {
      const FaceNode& node = graph[i];
      glm::dvec3 sum = glm::dvec3(node.normal) * static_cast<double>(node.area);
      for (const std::uint32_t other : node.neighbors) {
        if (other == kNoNeighbor || glm::distance(node.centroid, graph[other].centroid) > radius) continue;
        const float likeness = std::max(0.0f, glm::dot(node.normal, graph[other].normal));
        sum += glm::dvec3(graph[other].normal) * static_cast<double>(likeness * graph[other].area);
      }
      smoothed[i] = unit_or_zero(sum);
    });
    for_each_face(graph.size(), [&](std::size_t i) { graph[i].normal = smoothed[i]; });
  }
}

}  // namespace

FaceGraph make_face_graph(const Mesh& mesh, const std::vector<double>& areas, double smoothing_radius) {
  FaceGraph graph;
  measure(graph, mesh, areas);
  connect(graph, mesh);
  smooth_normals(graph, smoothing_radius);
  return graph;
}

}  // namespace lumatlas
