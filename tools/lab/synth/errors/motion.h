// SPDX-License-Identifier: GPL-3.0-or-later
// Moves synthetic cameras: for poses that are written wrongly, and while the shutter is open.
#pragma once

#include <glm/vec3.hpp>

#include "mesh/camera/camera.h"

namespace lumatlas::synth {

// A rigid motion of the camera frame: a turn by |rotation| radians about that axis through the camera's centre, then a
// shift in scene units.
struct Motion {
  glm::dvec3 rotation{0.0}, translation{0.0};
  bool operator==(const Motion&) const = default;
};

[[nodiscard]] Motion operator*(double scale, const Motion& motion);
[[nodiscard]] Camera moved(const Camera& camera, const Motion& motion);

}  // namespace lumatlas::synth
