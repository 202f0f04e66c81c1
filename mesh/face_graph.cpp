// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/face_graph.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

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
  graph.neighbors.resize(mesh.faces.size());
  for_each_face(mesh.faces.size(), [&](std::size_t i) {
    const glm::uvec3& face = mesh.faces[i];
    const auto index = static_cast<std::uint32_t>(i);
    graph.neighbors[i] = {across(mesh, around, index, face.x, face.y), across(mesh, around, index, face.y, face.z),
                          across(mesh, around, index, face.z, face.x)};
  });
}

glm::vec3 unit_or_zero(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0 ? glm::vec3(v / length) : glm::vec3(0);
}

void measure(FaceGraph& graph, const Mesh& mesh, const std::vector<double>& areas) {
  graph.areas.assign(areas.begin(), areas.end());
  graph.centroids.resize(mesh.faces.size());
  graph.normals.resize(mesh.faces.size());
  for_each_face(mesh.faces.size(), [&](std::size_t i) {
    const glm::uvec3& face = mesh.faces[i];
    const glm::dvec3 a(mesh.positions[face.x]);
    const glm::dvec3 b(mesh.positions[face.y]);
    const glm::dvec3 c(mesh.positions[face.z]);
    graph.centroids[i] = (a + b + c) / 3.0;
    graph.normals[i] = unit_or_zero(glm::cross(b - a, c - a));
  });
}

// Each pass carries a normal to the next neighbours; after k passes it has reached about sqrt(k) of them.
void smooth_normals(FaceGraph& graph, double radius) {
  constexpr int kPasses = 4;
  std::vector<glm::vec3> smoothed(graph.size());
  for (int pass = 0; pass < kPasses; ++pass) {
    for_each_face(graph.size(), [&](std::size_t i) {
      glm::dvec3 sum = glm::dvec3(graph.normals[i]) * static_cast<double>(graph.areas[i]);
      for (const std::uint32_t other : graph.neighbors[i]) {
        if (other == kNoNeighbor || glm::distance(graph.centroids[i], graph.centroids[other]) > radius) continue;
        sum += glm::dvec3(graph.normals[other]) * static_cast<double>(graph.areas[other]);
      }
      smoothed[i] = unit_or_zero(sum);
    });
    graph.normals.swap(smoothed);
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
