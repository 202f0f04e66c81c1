// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/camera/shutter_motion.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "mesh/base/requirement.h"

namespace lumatlas {

void check(const ShutterMotion& motion) {
  constexpr Requirement shutter_motion_requires{"shutter motion"};
  for (int axis = 0; axis < 3; ++axis) {
    shutter_motion_requires(std::isfinite(motion.turn[axis]), "turn", motion.turn[axis], "finite");
    shutter_motion_requires(std::isfinite(motion.shift[axis]), "shift", motion.shift[axis], "finite");
  }
}

// The line that shows the point depends on when it is read. Motions of some pixels are far shorter than a picture, so
// that three steps find it within a hundredth of a pixel.
glm::dvec3 when_read(const ShutterMotion& motion, const Camera& camera, const glm::dvec3& cam) {
  const glm::dvec3 velocity = glm::cross(motion.turn, cam) + motion.shift;
  glm::dvec3 moved = cam;
  for (int step = 0; step < 3 && moved.z > 0; ++step) {
    const double time = std::clamp(readout_time(camera, camera.image_from_cam(moved)), -0.5, 0.5);
    moved = cam + time * velocity;
  }
  return moved;
}

glm::dvec2 when_read(const ShutterMotion& motion, const Camera& camera, const glm::dvec2& image) {
  if (motion == ShutterMotion{}) return image;
  const glm::dvec3 cam((image.x - camera.cx) / camera.fx, (image.y - camera.cy) / camera.fy, 1.0);
  const glm::dvec3 moved = when_read(motion, camera, cam);
  return moved.z > 0 ? camera.image_from_cam(moved) : image;
}

double edge_move_px(const ShutterMotion& motion, const Camera& camera) {
  double most = 0;
  for (const double x : {0.0, 0.5 * camera.width, 1.0 * camera.width}) {
    for (const double y : {0.0, 0.5 * camera.height, 1.0 * camera.height}) {
      most = std::max(most, glm::distance(when_read(motion, camera, glm::dvec2(x, y)), glm::dvec2(x, y)));
    }
  }
  return most;
}

}  // namespace lumatlas
