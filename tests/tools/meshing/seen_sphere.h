// SPDX-License-Identifier: GPL-3.0-or-later
// The unit sphere, its points, and views around that see those on their side: a surface whose truth is known.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <vector>

#include "mesh/camera/camera.h"

namespace lumatlas {

// Evenly over the sphere, on a spiral by the golden angle.
inline std::vector<glm::dvec3> sphere_points(std::size_t count) {
  std::vector<glm::dvec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const double z = 1 - 2 * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    const double angle = 2.399963229728653 * static_cast<double>(i), radius = std::sqrt(1 - z * z);
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
  return points;
}

// 400 x 400 pixels, 5 from the middle of the sphere, which each looks at.
inline std::vector<Camera> views_around(std::size_t count) {
  std::vector<Camera> views;
  for (const glm::dvec3& direction : sphere_points(count)) {
    Camera view;
    view.width = view.height = 400;
    view.fx = view.fy = 800;
    view.cx = view.cy = 200;
    const glm::dvec3 forward = -direction;
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0.3, 0.5, 0.81)));
    const glm::dvec3 down = glm::cross(forward, right);
    view.cam_from_world_rotation = glm::transpose(glm::dmat3(right, down, forward));
    view.cam_from_world_translation = -(view.cam_from_world_rotation * (5.0 * direction));
    views.push_back(view);
  }
  return views;
}

inline std::vector<std::vector<std::uint32_t>> views_that_see(const std::vector<glm::dvec3>& on_sphere,
                                                              const std::vector<Camera>& views) {
  std::vector<std::vector<std::uint32_t>> seen(on_sphere.size());
  for (std::size_t i = 0; i < on_sphere.size(); ++i) {
    for (std::size_t view = 0; view < views.size(); ++view) {
      const glm::dvec3 sight = glm::normalize(views[view].center() - on_sphere[i]);
      if (glm::dot(sight, on_sphere[i]) > 0.2) seen[i].push_back(static_cast<std::uint32_t>(view));
    }
  }
  return seen;
}

inline std::vector<glm::dvec3> centers_of(const std::vector<Camera>& views) {
  std::vector<glm::dvec3> centers;
  for (const Camera& view : views) centers.push_back(view.center());
  return centers;
}

}  // namespace lumatlas
