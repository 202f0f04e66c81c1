// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/model_ranges.h"

#include <algorithm>
#include <glm/glm.hpp>
#include <stdexcept>
#include <string>

#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

void require_in_model_range(const std::string& field, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw std::invalid_argument("camera: " + field + " is " + number_text(value) + ", must be in [" + number_text(least) +
                              ", " + number_text(most) + "]");
}

}  // namespace

double most_cell_size(const Mesh& mesh) {
  const Bounds box = bounds(mesh);
  return box.empty() ? 0 : glm::length(box.max - box.min);
}

void check_model_ranges(const Camera& camera) {
  const double side = std::max(camera.width, camera.height);
  require_in_model_range("fx", camera.fx, side / kMostSidePerFocalLength, kMostFocalShare * side);
  require_in_model_range("fy", camera.fy, side / kMostSidePerFocalLength, kMostFocalShare * side);
  require_in_model_range("cx", camera.cx, -kMostPrincipalShare * side, kMostPrincipalShare * side);
  require_in_model_range("cy", camera.cy, -kMostPrincipalShare * side, kMostPrincipalShare * side);
  for (int axis = 0; axis < 3; ++axis) {
    require_in_model_range("translation[" + std::to_string(axis) + "]", camera.cam_from_world_translation[axis],
                           -kMostTranslation, kMostTranslation);
  }
}

}  // namespace lumatlas
