// SPDX-License-Identifier: GPL-3.0-or-later
// Exact depth images of the unit ball, and what a surface that is fused of them is asked.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "mesh/mesh.h"
#include "tools/meshing/depth/depth_fusion.h"

namespace lumatlas {

// Looks at the origin.
[[nodiscard]] inline Camera camera_at(const glm::dvec3& center) {
  Camera camera;
  camera.width = 160;
  camera.height = 120;
  camera.fx = camera.fy = 150;
  camera.cx = 80;
  camera.cy = 60;
  const glm::dvec3 forward = -glm::normalize(center);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0.11, 0.23, 1)));
  camera.cam_from_world_rotation = glm::transpose(glm::dmat3(right, glm::cross(forward, right), forward));
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * center);
  return camera;
}

// Exact depths of the unit ball.
[[nodiscard]] inline DepthImage ball_from(const glm::dvec3& center) {
  DepthImage image{camera_at(center), {}};
  for (std::uint32_t y = 0; y < image.camera.height; ++y) {
    for (std::uint32_t x = 0; x < image.camera.width; ++x) {
      const glm::dvec3 ray = image.camera.ray({x + 0.5, y + 0.5});
      const double a = glm::dot(ray, ray);
      const double half = glm::dot(ray, center);
      const double root = half * half - a * (glm::dot(center, center) - 1);
      image.depth.push_back(root < 0 ? 0.0F : static_cast<float>((-half - std::sqrt(root)) / a));
    }
  }
  return image;
}

[[nodiscard]] inline std::vector<DepthImage> ball_from_all_sides() {
  std::vector<DepthImage> images;
  for (const double x : {-2.5, 2.5}) {
    for (const double y : {-2.5, 2.5}) {
      for (const double z : {-2.5, 2.5}) images.push_back(ball_from({x, y, z}));
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-3.5, 3.5}) {
      glm::dvec3 center(0.0);
      center[axis] = side;
      images.push_back(ball_from(center));
    }
  }
  return images;
}

// Edges of one face alone.
[[nodiscard]] inline std::size_t open_edges(const TriangleSoup& soup) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  for (const glm::uvec3& face : soup.faces) {
    for (int corner = 0; corner < 3; ++corner) {
      const auto [low, high] = std::minmax({face[corner], face[(corner + 1) % 3]});
      ++uses[{low, high}];
    }
  }
  return static_cast<std::size_t>(
      std::count_if(uses.begin(), uses.end(), [](const auto& edge) { return edge.second == 1; }));
}

[[nodiscard]] inline FusionOptions ball_options() {
  FusionOptions options;
  options.voxel = 0.05;
  options.truncation = 0.15;
  options.least_weight = 0.01;
  return options;
}

// The coordinates, so that they can be looked up.
[[nodiscard]] inline std::set<std::tuple<double, double, double>> vertices_of(const TriangleSoup& soup) {
  std::set<std::tuple<double, double, double>> vertices;
  for (const glm::dvec3& p : soup.positions) vertices.emplace(p.x, p.y, p.z);
  return vertices;
}

}  // namespace lumatlas
