// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/visibility/shown_box.h"

#include <algorithm>
#include <glm/common.hpp>
#include <limits>

namespace lumatlas {

ShownBox shown_box(const Camera& camera, const Bounds& box) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  glm::dvec2 low(kInfinity), high(-kInfinity);
  double near = kInfinity, far = -kInfinity;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 world((corner & 1) != 0 ? box.max.x : box.min.x, (corner & 2) != 0 ? box.max.y : box.min.y,
                           (corner & 4) != 0 ? box.max.z : box.min.z);
    const glm::dvec3 cam = camera.cam_from_world(world);
    near = std::min(near, cam.z);
    far = std::max(far, cam.z);
    if (cam.z <= 0) continue;
    const glm::dvec2 image = camera.image_from_cam(cam);
    low = glm::min(low, image);
    high = glm::max(high, image);
  }
  if (far <= 0) return {};
  if (near <= 0) return {0, 0, camera.width, camera.height, 0, far};
  const glm::dvec2 size(camera.width, camera.height);
  low = glm::clamp(glm::floor(low), glm::dvec2(0), size);
  high = glm::clamp(glm::ceil(high), low, size);
  return {static_cast<std::uint32_t>(low.x),
          static_cast<std::uint32_t>(low.y),
          static_cast<std::uint32_t>(high.x),
          static_cast<std::uint32_t>(high.y),
          near,
          far};
}

}  // namespace lumatlas
