// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: the pyramid that a camera sees.
#pragma once

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "mesh/camera/camera.h"

namespace lumatlas {

// Unit normals, in the camera frame, of the planes that bound what the camera sees; all pass through its centre, and
// the normals point to the side that is seen.
using ViewPyramid = std::array<glm::dvec3, 5>;

[[nodiscard]] inline ViewPyramid view_pyramid(const Camera& camera) {
  return {{{0, 0, 1},
           glm::normalize(glm::dvec3(camera.fx, 0, camera.cx)),
           glm::normalize(glm::dvec3(-camera.fx, 0, camera.width - camera.cx)),
           glm::normalize(glm::dvec3(0, camera.fy, camera.cy)),
           glm::normalize(glm::dvec3(0, -camera.fy, camera.height - camera.cy))}};
}

// Returns true only if the camera sees nothing of a ball, whose centre is in the camera frame.
[[nodiscard]] inline bool outside(const ViewPyramid& pyramid, const glm::dvec3& center, double radius) {
  return std::any_of(pyramid.begin(), pyramid.end(),
                     [&](const glm::dvec3& normal) { return glm::dot(normal, center) < -radius; });
}

}  // namespace lumatlas
