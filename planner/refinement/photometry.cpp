// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/photometry.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace lumatlas {

double srgb_slope(double linear) {
  const double at = std::max(linear, 0.01);
  return 1.055 / 2.4 * std::pow(at, 1 / 2.4 - 1);
}

Robust tukey(double r) {
  const double u = r * r / (kTukeyCutoff * kTukeyCutoff);
  if (u >= 1) return {std::copysign(kTukeyCutoff / std::sqrt(3.0), r), 0};
  const double root = std::sqrt(1 - u + u * u / 3);
  return {r * root, (1 - u) * (1 - u) / root};
}

Camera moved(Camera camera, const glm::dvec3& turn, const glm::dvec3& shift) {
  const double angle = glm::length(turn);
  const glm::dmat3 rotation = angle > 0 ? glm::mat3_cast(glm::angleAxis(angle, turn / angle)) : glm::dmat3(1.0);
  camera.cam_from_world_rotation = rotation * camera.cam_from_world_rotation;
  camera.cam_from_world_translation = rotation * camera.cam_from_world_translation + shift;
  return camera;
}

CameraMotion motion_between(const Camera& from, const Camera& to) {
  const glm::dmat3 rotation = to.cam_from_world_rotation * glm::transpose(from.cam_from_world_rotation);
  const glm::dquat turn = glm::quat_cast(rotation);
  const glm::dvec3 axis(turn.x, turn.y, turn.z);
  const double sine = glm::length(axis);
  const double angle = 2 * std::atan2(sine, turn.w);
  return {sine > 0 ? axis * (angle / sine) : glm::dvec3(0),
          to.cam_from_world_translation - rotation * from.cam_from_world_translation};
}

bool same_pose(const Camera& a, const Camera& b) {
  return a.cam_from_world_rotation == b.cam_from_world_rotation &&
         a.cam_from_world_translation == b.cam_from_world_translation;
}

}  // namespace lumatlas
