// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: the surface over which clusters grow, from face to face across OpenMesh's halfedges.
#pragma once

#include <OpenMesh/Core/Mesh/TriConnectivity.hh>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <vector>

#include "mesh/face_geometry.h"
#include "mesh/mesh.h"

namespace lumatlas {

inline constexpr std::uint32_t kNoCluster = std::numeric_limits<std::uint32_t>::max();

// What clustering needs to know of a face. Together, because growing a cluster reads them together and in no order that
// a cache could foresee; aligned so that none lies in two cache lines.
struct alignas(32) ClusterFace {
  glm::vec3 centroid;
  glm::vec3 normal;  // unit, smoothed; zero where a face has no area
  float area;        // scene units squared
};

class ClusterMesh {
 public:
  // `geometry` holds one per face. Normals are averaged over faces up to about a sixth of `cell_size` away, because
  // those of scanned surfaces are noisy; neighbours whose centroids are further apart than that keep theirs, so that
  // coarse meshes keep their creases.
  ClusterMesh(const Mesh& mesh, std::span<const FaceGeometry> geometry, double cell_size);

  [[nodiscard]] std::size_t size() const { return faces_.size(); }
  [[nodiscard]] const ClusterFace& operator[](std::size_t face) const { return faces_[face]; }

  // Calls visit(neighbour) for the face across each edge that is no boundary, beginning with the edge from the face's
  // first corner to its second. Edges that are not manifold are boundaries (halfedge_mesh.h).
  template <typename Visit>
  void for_each_neighbor(std::uint32_t face, const Visit& visit) const {
    auto halfedge = connectivity_.halfedge_handle(face_handle(face));
    for (int edge = 0; edge < 3; ++edge) {
      halfedge = connectivity_.next_halfedge_handle(halfedge);
      const auto across = connectivity_.face_handle(connectivity_.opposite_halfedge_handle(halfedge));
      if (across.is_valid()) visit(static_cast<std::uint32_t>(across.idx()));
    }
  }

  // Growing waits for memory more than it works. These ask the processor for what for_each_neighbor() will read of a
  // face; each reads what the one before asked for, so that some work should lie between.
  void prefetch_halfedge(std::uint32_t face) const { __builtin_prefetch(&connectivity_.face(face_handle(face))); }
  void prefetch_first_edge(std::uint32_t face) const {
    prefetch_edge(connectivity_.halfedge_handle(face_handle(face)));
  }
  void prefetch_other_edges(std::uint32_t face) const {
    const auto halfedge = connectivity_.halfedge_handle(face_handle(face));
    prefetch_edge(connectivity_.next_halfedge_handle(halfedge));
    prefetch_edge(connectivity_.prev_halfedge_handle(halfedge));
  }

 private:
  [[nodiscard]] static OpenMesh::FaceHandle face_handle(std::uint32_t face) {
    return OpenMesh::FaceHandle(static_cast<int>(face));
  }
  void prefetch_edge(OpenMesh::HalfedgeHandle halfedge) const { __builtin_prefetch(&connectivity_.halfedge(halfedge)); }
  void smooth_normals(double radius);

  OpenMesh::TriConnectivity connectivity_;
  std::vector<ClusterFace> faces_;
};

}  // namespace lumatlas
