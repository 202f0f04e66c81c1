// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/simplification.h"

#include <meshoptimizer.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec3.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "mesh/halfedge_mesh.h"
#include "mesh/repair/repair.h"

namespace lumatlas {

namespace {

static_assert(sizeof(glm::uvec3) == 3 * sizeof(unsigned int), "meshoptimizer takes the faces as they are");

// Without the pairs of faces that lie back to back on the same three vertices: what is left of a fold that collapsed.
std::vector<glm::uvec3> without_folds(const std::vector<glm::uvec3>& faces) {
  const auto corners = [&](std::size_t face) {
    std::array<std::uint32_t, 3> sorted{faces[face].x, faces[face].y, faces[face].z};
    std::sort(sorted.begin(), sorted.end());
    return sorted;
  };
  std::vector<std::pair<std::array<std::uint32_t, 3>, std::size_t>> by_corners;
  for (std::size_t face = 0; face < faces.size(); ++face) by_corners.emplace_back(corners(face), face);
  tbb::parallel_sort(by_corners.begin(), by_corners.end());
  std::vector<bool> folded(faces.size(), false);
  for (std::size_t i = 0; i + 1 < by_corners.size(); ++i) {
    if (by_corners[i].first != by_corners[i + 1].first) continue;
    folded[by_corners[i].second] = folded[by_corners[i + 1].second] = true;
    ++i;
  }
  std::vector<glm::uvec3> rest;
  for (std::size_t face = 0; face < faces.size(); ++face) {
    if (!folded[face]) rest.push_back(faces[face]);
  }
  return rest;
}

// The vertices that faces use, in their order, with these faces.
Mesh used_part(const Mesh& mesh, const std::vector<glm::uvec3>& faces) {
  constexpr std::uint32_t kUnused = ~0u;
  std::vector<std::uint32_t> index(mesh.positions.size(), kUnused);
  for (const glm::uvec3& face : faces) index[face.x] = index[face.y] = index[face.z] = 0;
  Mesh part;
  for (std::size_t vertex = 0; vertex < index.size(); ++vertex) {
    if (index[vertex] == kUnused) continue;
    index[vertex] = static_cast<std::uint32_t>(part.positions.size());
    part.positions.push_back(mesh.positions[vertex]);
    if (!mesh.colors.empty()) part.colors.push_back(mesh.colors[vertex]);
  }
  part.faces.reserve(faces.size());
  for (const glm::uvec3& face : faces) part.faces.emplace_back(index[face.x], index[face.y], index[face.z]);
  return part;
}

// Returns the halfedge of a face's longest edge if the third corner lies on it, so that the face has no area.
std::optional<HalfedgeMesh::HalfedgeHandle> edge_of_flat_face(const HalfedgeMesh& mesh, HalfedgeMesh::FaceHandle face) {
  constexpr float kFlat = 1e-6F;  // share of the edge's length: about the resolution of floats
  HalfedgeMesh::HalfedgeHandle longest;
  float length = 0, area = 0;
  for (HalfedgeMesh::HalfedgeHandle edge : mesh.fh_range(face)) {
    const OpenMesh::Vec3f along = mesh.calc_edge_vector(edge);
    if (along.norm() > length) {
      length = along.norm();
      longest = edge;
    }
    area = along.cross(mesh.calc_edge_vector(mesh.next_halfedge_handle(edge))).norm();
  }
  if (!(area <= kFlat * length * length) || !longest.is_valid()) return std::nullopt;
  return longest;
}

// A face without area becomes one of its neighbour's two halves: removed, it would leave a crack.
void flip_flat_faces(HalfedgeMesh& mesh) {
  constexpr int kMostInARow = 8;  // that lie along one edge
  for (int pass = 0; pass < kMostInARow; ++pass) {
    bool flipped = false;
    for (const HalfedgeMesh::FaceHandle face : mesh.faces()) {
      const std::optional<HalfedgeMesh::HalfedgeHandle> edge = edge_of_flat_face(mesh, face);
      if (!edge || !mesh.is_flip_ok(mesh.edge_handle(*edge))) continue;
      mesh.flip(mesh.edge_handle(*edge));
      flipped = true;
    }
    if (!flipped) return;
  }
}

TriangleSoup to_soup(const Mesh& mesh) {
  return {{mesh.positions.begin(), mesh.positions.end()}, mesh.colors, mesh.faces};
}

// Collapses may leave folds and faces without area, and make two sheets meet in an edge or a vertex.
Mesh mended(const Mesh& mesh, const std::vector<glm::uvec3>& faces) {
  HalfedgeMesh halfedge_mesh = to_halfedge_mesh(used_part(mesh, without_folds(faces)));
  flip_flat_faces(halfedge_mesh);
  return repair(to_soup(from_halfedge_mesh(halfedge_mesh, !mesh.colors.empty())), glm::dvec3(0)).mesh;
}

double nearest_pixel(const glm::dvec3& vertex, std::span<const Camera> cameras) {
  double least = std::numeric_limits<double>::infinity();
  for (const Camera& camera : cameras) {
    const glm::dvec3 cam = camera.cam_from_world(vertex);
    const double size = cam.z / std::min(camera.fx, camera.fy);
    if (!(cam.z > 0 && size < least)) continue;
    const glm::dvec2 image = camera.image_from_cam(cam);
    if (image.x >= 0 && image.y >= 0 && image.x < camera.width && image.y < camera.height) least = size;
  }
  return least;
}

}  // namespace

SimplifiedMesh simplified(const Mesh& mesh, const SimplificationBound& bound) {
  check(mesh);
  if (!(bound.distance >= 0)) {
    throw std::invalid_argument("simplification: bound.distance is " + std::to_string(bound.distance) +
                                ", must not be negative");
  }
  if (mesh.faces.size() <= bound.faces || mesh.faces.empty() || bound.distance == 0) return {mesh, 0};
  constexpr std::size_t kStride = sizeof(glm::vec3);
  const double scale = meshopt_simplifyScale(&mesh.positions[0].x, mesh.positions.size(), kStride);
  const double most = std::min(bound.distance / scale, 1.0);  // no surface can move by more than its own size
  std::vector<glm::uvec3> faces(mesh.faces.size());
  float moved = 0;
  const std::size_t indices =
      meshopt_simplify(&faces[0].x, &mesh.faces[0].x, 3 * mesh.faces.size(), &mesh.positions[0].x,
                       mesh.positions.size(), kStride, 3 * bound.faces, static_cast<float>(most), 0, &moved);
  faces.resize(indices / 3);
  if (faces.empty() || faces.size() == mesh.faces.size()) return {mesh, 0};
  return {mended(mesh, faces), scale * static_cast<double>(moved)};
}

double pixel_size(const Mesh& mesh, std::span<const Camera> cameras, double share) {
  constexpr std::size_t kMostVertices = 20000;
  check(mesh);
  for (const Camera& camera : cameras) check(camera);
  if (!(share >= 0 && share <= 1)) {
    throw std::invalid_argument("pixel size: share is " + std::to_string(share) + ", must be in [0, 1]");
  }
  const std::size_t step = mesh.positions.size() / kMostVertices + 1;
  std::vector<double> sizes((mesh.positions.size() + step - 1) / step);
  tbb::parallel_for(std::size_t{0}, sizes.size(),
                    [&](std::size_t i) { sizes[i] = nearest_pixel(glm::dvec3(mesh.positions[i * step]), cameras); });
  std::erase_if(sizes, [](double size) { return !std::isfinite(size); });
  if (sizes.empty()) return std::numeric_limits<double>::infinity();
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), at, sizes.end());
  return *at;
}

}  // namespace lumatlas
