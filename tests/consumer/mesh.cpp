// SPDX-License-Identifier: GPL-3.0-or-later
#include <iostream>

#include "mesh/camera/camera.h"

int main() {
  lumatlas::Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 500;
  camera.cx = 320;
  camera.cy = 240;
  lumatlas::check(camera);
  const glm::dvec3 ahead = camera.center() + 2.0 * camera.ray({320, 240});
  std::cout << "the image's centre at depth 2 is " << ahead.x << ' ' << ahead.y << ' ' << ahead.z << '\n';
  return ahead == glm::dvec3(0, 0, 2) ? 0 : 1;
}
