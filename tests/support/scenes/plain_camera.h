// SPDX-License-Identifier: GPL-3.0-or-later
// A plain camera for tests of where cameras are.
#pragma once

#include <glm/vec3.hpp>

#include "mesh/camera/camera.h"

namespace lumatlas {

// 100 x 100 pixels with a focal length of 100; looks along +z from `center`.
inline Camera plain_camera(const glm::dvec3& center) {
  Camera camera;
  camera.width = camera.height = 100;
  camera.fx = camera.fy = 100;
  camera.cx = camera.cy = 50;
  camera.cam_from_world_translation = -center;
  return camera;
}

}  // namespace lumatlas
