// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: the dual graph of a mesh, whose nodes are the faces, with what clustering needs to know of each.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "mesh/mesh.h"

namespace lumatlas {

inline constexpr std::uint32_t kNoNeighbor = std::numeric_limits<std::uint32_t>::max();

// Together, because growing a cluster reads them together and in no order that a cache could foresee.
struct FaceNode {
  glm::vec3 centroid;
  glm::vec3 normal;  // unit, smoothed; zero where a face has no area
  float area;
  std::array<std::uint32_t, 3> neighbors;  // across each edge; kNoNeighbor at a boundary
};
using FaceGraph = std::vector<FaceNode>;

// The smoothing radius for clusters, of their size: small against a cell, several faces of a dense scan.
inline constexpr double kNormalSmoothing = 1.0 / 6;

// Normals are averaged over faces up to about `smoothing_radius` away, because those of scanned surfaces are noisy;
// neighbours whose centroids are further apart than that keep theirs, so that coarse meshes keep their creases.
[[nodiscard]] FaceGraph make_face_graph(const Mesh& mesh, const std::vector<double>& areas, double smoothing_radius);

}  // namespace lumatlas
