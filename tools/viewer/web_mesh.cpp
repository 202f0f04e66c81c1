// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/web_mesh.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <glm/glm.hpp>
#include <limits>
#include <vector>

#include "mesh/repair/simplification.h"

namespace lumatlas {

namespace {

constexpr double kStepsPerPixel = 64;
constexpr double kStepsPerCell = 100;
constexpr double kMostSteps = 1 << 30;

// The corners of the faces, one after the other.
std::vector<std::uint32_t> corners_of(const std::vector<glm::uvec3>& faces) {
  std::vector<std::uint32_t> corners;
  corners.reserve(3 * faces.size());
  for (const glm::uvec3& face : faces) corners.insert(corners.end(), {face.x, face.y, face.z});
  return corners;
}

// Faces in an order in which neighbours come one after the other: what is written as a difference is small then.
std::vector<std::uint32_t> ordered_corners(const ZoneMesh& mesh) {
  std::vector<std::uint32_t> corners = corners_of(mesh.faces);
  std::size_t first = 0;
  for (const std::size_t faces : mesh.face_counts) {
    meshopt_optimizeVertexCacheStrip(&corners[first], &corners[first], 3 * faces, mesh.positions.size());
    first += 3 * faces;
  }
  return corners;
}

// The vertices in the order in which the corners first name them; these are renumbered.
std::vector<std::uint32_t> by_first_corner(std::vector<std::uint32_t>& corners, std::size_t vertices) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> number(vertices, kNone);
  std::vector<std::uint32_t> order;
  for (std::uint32_t& corner : corners) {
    if (number[corner] == kNone) {
      number[corner] = static_cast<std::uint32_t>(order.size());
      order.push_back(corner);
    }
    corner = number[corner];
  }
  return order;
}

// The mesh in about `faces` faces; parts that do not hang together may be joined. `most_error`: fraction of the mesh's
// extent.
Mesh clustered(const Mesh& mesh, std::size_t faces, float most_error) {
  const std::vector<std::uint32_t> all = corners_of(mesh.faces);
  std::vector<std::uint32_t> corners(all.size());
  corners.resize(meshopt_simplifySloppy(corners.data(), all.data(), all.size(), &mesh.positions[0].x,
                                        mesh.positions.size(), sizeof(glm::vec3), 3 * faces, most_error, nullptr));
  Mesh result;
  for (const std::uint32_t vertex : by_first_corner(corners, mesh.positions.size())) {
    result.positions.push_back(mesh.positions[vertex]);
    result.colors.push_back(mesh.colors[vertex]);
  }
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    result.faces.emplace_back(corners[i], corners[i + 1], corners[i + 2]);
  }
  return result;
}

// The mesh as a single zone, in which nothing fades.
ZoneMesh zone_mesh_of(const Mesh& mesh) {
  ZoneMesh result;
  result.positions = mesh.positions;
  result.colors = mesh.colors;
  result.faces = mesh.faces;
  result.shares.resize(mesh.positions.size());
  result.zones.resize(mesh.positions.size());
  result.face_counts[0] = mesh.faces.size();
  return result;
}

}  // namespace

PositionGrid position_grid(const Snapshot& snapshot) {
  const Bounds box = bounds(snapshot.surface->mesh);
  const double longest = std::max({box.max.x - box.min.x, box.max.y - box.min.y, box.max.z - box.min.z});
  double step = snapshot.surface->cells.size / kStepsPerCell;
  for (const auto& view : snapshot.views) {
    if (!view) continue;
    const double depth = median_depth(*view, depth_before_far(*snapshot.surface));
    if (depth > 0) step = std::min(step, depth / (std::max(view->camera.fx, view->camera.fy) * kStepsPerPixel));
  }
  step = std::max(step, longest / kMostSteps);
  return {box.min, step > 0 ? step : 1};
}

PackedMesh packed_mesh(const ZoneMesh& mesh, const PositionGrid& grid) {
  std::vector<std::uint32_t> corners = ordered_corners(mesh);
  const std::vector<std::uint32_t> order = by_first_corner(corners, mesh.positions.size());
  std::vector<std::uint32_t> positions, colors, shares, zones;
  for (const std::uint32_t vertex : order) {
    const glm::dvec3 steps = glm::round((glm::dvec3(mesh.positions[vertex]) - grid.origin) / grid.step);
    for (int axis = 0; axis < 3; ++axis) {
      positions.push_back(static_cast<std::uint32_t>(steps[axis]));
      colors.push_back(mesh.colors[vertex][axis]);
      // The first pass keeps 10 bits of it, and 8 are enough for a fade.
      shares.push_back((mesh.shares[vertex][axis] * 255u + 32767u) / 65535u);
    }
    zones.push_back(mesh.zones[vertex]);
  }
  PackedMesh packed{{}, grid, {}, order};
  for (const std::size_t faces : mesh.face_counts) packed.corner_counts.push_back(3 * faces);
  packed.arrays.add("corners", corners, 3, PackedCoding::corners);
  packed.arrays.add("positions", positions, 3, PackedCoding::difference);
  packed.arrays.add("colors", colors, 3, PackedCoding::difference);
  packed.arrays.add("shares", shares, 3, PackedCoding::difference);
  packed.arrays.add("zones", zones, 1, PackedCoding::difference);
  return packed;
}

ZoneMesh coarse_mesh(const Snapshot& snapshot, std::size_t faces) {
  constexpr float kMostError = 0.02F;  // share of the mesh's extent
  const Mesh mesh = near_surface(*snapshot.surface).mesh;
  if (mesh.faces.size() <= 2 * faces) return {};
  const auto colors = snapshot.vertex_colors.get().begin();
  const Mesh colored{mesh.positions, {colors, colors + static_cast<std::ptrdiff_t>(mesh.positions.size())}, mesh.faces};
  const Bounds box = bounds(mesh);
  const double extent = std::max({box.max.x - box.min.x, box.max.y - box.min.y, box.max.z - box.min.z});
  const Mesh few = simplified(colored, {kMostError * extent, faces}).mesh;
  // A surface in many small pieces, or with many borders, has edges that may not go.
  return zone_mesh_of(few.faces.size() > 2 * faces ? clustered(colored, faces, kMostError) : few);
}

}  // namespace lumatlas
