// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: the surface over which clusters grow, from face to face across OpenMesh's halfedges.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <vector>

#include "mesh/base/id.h"
#include "mesh/face_geometry.h"
#include "mesh/mesh.h"

namespace lumatlas {

inline constexpr std::uint32_t kNoCluster = std::numeric_limits<std::uint32_t>::max();

// The values of a face that clustering reads. They lie together because growing a cluster reads them together, in an
// order that a cache cannot foresee. They are aligned so that none lies in two cache lines.
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
  [[nodiscard]] const ClusterFace& operator[](FaceId face) const { return faces_[face]; }

  // Calls visit(neighbour) for the face across each edge that is no boundary, beginning with the edge from the face's
  // first corner to its second. Edges that are not manifold are boundaries (halfedge_mesh.h).
  template <typename Visit>
  void for_each_neighbor(FaceId face, const Visit& visit) const {
    for (const FaceId neighbor : neighbors_[face]) {
      if (neighbor != FaceId::none) visit(neighbor);
    }
  }

  // Growing waits for memory more than it works. This asks the processor for what for_each_neighbor() will read.
  void prefetch_neighbors(FaceId face) const { __builtin_prefetch(&neighbors_[face]); }

 private:
  void find_neighbors(const Mesh& mesh);
  void smooth_normals(double radius);

  // The face across each edge of a face; FaceId::none at a boundary. Read once from OpenMesh's opposite halfedges,
  // because growing visits every face several times and a walk over halfedges waits for memory at every step.
  std::vector<std::array<FaceId, 3>> neighbors_;
  std::vector<ClusterFace> faces_;
};

}  // namespace lumatlas
