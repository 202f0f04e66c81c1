// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/cells/cluster_mesh.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "mesh/halfedge_mesh.h"

namespace lumatlas {

namespace {

template <typename Body>
void for_each_face(std::size_t faces, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(faces), 1024),
                    [&](const auto& range) {
                      for (FaceId face{range.begin()}; face < range.end(); ++face) body(face);
                    });
}

glm::vec3 unit_or_zero(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0 ? glm::vec3(v / length) : glm::vec3(0);
}

}  // namespace

ClusterMesh::ClusterMesh(const Mesh& mesh, std::span<const FaceGeometry> geometry, double cell_size)
    : neighbors_(mesh.faces.size()), faces_(mesh.faces.size()) {
  constexpr double kNormalSmoothing = 1.0 / 6;  // small against a cell, several faces of a dense scan
  find_neighbors(mesh);
  for_each_face(faces_.size(), [&](FaceId face) {
    const glm::uvec3& corners = mesh.faces[face];
    const glm::dvec3 a(mesh.positions[corners.x]);
    const glm::dvec3 b(mesh.positions[corners.y]);
    const glm::dvec3 c(mesh.positions[corners.z]);
    faces_[face] = {(a + b + c) / 3.0, geometry[face].normal, static_cast<float>(geometry[face].area)};
  });
  smooth_normals(kNormalSmoothing * cell_size);
}

void ClusterMesh::find_neighbors(const Mesh& mesh) {
  OpenMesh::TriConnectivity connectivity;
  connect(mesh, connectivity);
  for_each_face(neighbors_.size(), [&](FaceId face) {
    auto halfedge = connectivity.halfedge_handle(OpenMesh::FaceHandle(static_cast<int>(std::uint32_t{face})));
    for (FaceId& neighbor : neighbors_[face]) {
      halfedge = connectivity.next_halfedge_handle(halfedge);
      const auto across = connectivity.face_handle(connectivity.opposite_halfedge_handle(halfedge));
      neighbor = across.is_valid() ? FaceId{static_cast<std::uint32_t>(across.idx())} : FaceId::none;
    }
  });
}

// Each pass carries a normal to the next neighbours; after k passes it has reached about sqrt(k) of them.
void ClusterMesh::smooth_normals(double radius) {
  constexpr int kPasses = 8;
  std::vector<glm::vec3> smoothed(faces_.size());
  for (int pass = 0; pass < kPasses; ++pass) {
    for_each_face(faces_.size(), [&](FaceId face) {
      const ClusterFace& own = faces_[face];
      glm::dvec3 sum = glm::dvec3(own.normal) * static_cast<double>(own.area);
      for_each_neighbor(face, [&](FaceId neighbor) {
        const ClusterFace& other = faces_[neighbor];
        if (glm::distance(own.centroid, other.centroid) > radius) return;
        const float likeness = std::max(0.0f, glm::dot(own.normal, other.normal));
        sum += glm::dvec3(other.normal) * static_cast<double>(likeness * other.area);
      });
      smoothed[face] = unit_or_zero(sum);
    });
    for_each_face(faces_.size(), [&](FaceId face) { faces_[face].normal = smoothed[face]; });
  }
}

}  // namespace lumatlas
