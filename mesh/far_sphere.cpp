// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/far_sphere.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "mesh/base/median.h"
#include "mesh/base/requirement.h"
#include "mesh/cells/split_faces.h"
#include "mesh/scene_extent.h"

namespace lumatlas {

namespace {

constexpr Requirement far_sphere_requires{"far sphere"};

constexpr double kCameraDistances = 300;  // radius of the sphere, in distances of the outer cameras
constexpr double kMeshDistances = 10;     // the least, in distances of the bulk of the mesh
constexpr double kSpread = 0.9;           // share of the cameras that are not farther than the outer ones

// A regular icosahedron on the unit sphere; its faces are counterclockwise as seen from inside.
Mesh icosahedron() {
  const auto b = static_cast<float>(1 / std::sqrt(1 + std::numbers::phi * std::numbers::phi));
  const auto a = static_cast<float>(std::numbers::phi * b);
  Mesh mesh;
  mesh.positions = {{-b, a, 0},  {b, a, 0},  {-b, -a, 0}, {b, -a, 0}, {0, -b, a},  {0, b, a},
                    {0, -b, -a}, {0, b, -a}, {a, 0, -b},  {a, 0, b},  {-a, 0, -b}, {-a, 0, b}};
  mesh.faces = {{0, 5, 11},  {0, 1, 5},  {0, 7, 1},  {0, 10, 7}, {0, 11, 10}, {1, 9, 5}, {5, 4, 11},
                {11, 2, 10}, {10, 6, 7}, {7, 8, 1},  {3, 4, 9},  {3, 2, 4},   {3, 6, 2}, {3, 8, 6},
                {3, 9, 8},   {4, 5, 9},  {2, 11, 4}, {6, 10, 2}, {8, 7, 6},   {9, 1, 8}};
  return mesh;
}

}  // namespace

SphereShape far_sphere_shape(std::span<const Camera> cameras, const Mesh& mesh) {
  far_sphere_requires(!cameras.empty(), "the number of cameras", 0, "at least 1");
  far_sphere_requires(!mesh.faces.empty(), "the number of faces", 0, "at least 1");
  SphereShape shape;
  std::vector<double> values(cameras.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(cameras.begin(), cameras.end(), values.begin(),
                   [&](const Camera& camera) { return camera.center()[axis]; });
    shape.center[axis] = upper_median(values);
  }
  std::transform(cameras.begin(), cameras.end(), values.begin(),
                 [&](const Camera& camera) { return glm::distance(shape.center, camera.center()); });
  const double spread = percentile(values, kSpread);
  const SceneExtent extent = scene_extent(mesh);
  const glm::dvec3 middle = (extent.core.min + extent.core.max) / 2.0;
  shape.radius =
      std::max(kCameraDistances * spread, kMeshDistances * (glm::distance(shape.center, middle) + extent.diameter / 2));
  return shape;
}

Mesh far_sphere(const SphereShape& shape, double longest_edge) {
  far_sphere_requires(longest_edge > 0 && longest_edge <= 1, "longest_edge", longest_edge, "in (0, 1]");
  // Projection makes edges longer, by at most the radius over that of the inscribed sphere, 1.26.
  constexpr double kLongerProjected = 1.26;
  Mesh mesh = split_large_faces(icosahedron(), longest_edge / kLongerProjected);
  for (glm::vec3& position : mesh.positions) {
    position = glm::vec3(shape.center + shape.radius * glm::normalize(glm::dvec3(position)));
  }
  return mesh;
}

}  // namespace lumatlas
