// SPDX-License-Identifier: GPL-3.0-or-later
// Tests whether all coordinates of a point are finite numbers.
#pragma once

#include <cmath>
#include <glm/vec3.hpp>

namespace lumatlas {

[[nodiscard]] inline bool is_finite(const glm::dvec3& point) {
  return std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z);
}

}  // namespace lumatlas
