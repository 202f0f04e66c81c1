// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the upward direction of a scene from its cameras, and the rotation that makes the scene upright.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>

#include "mesh/camera/camera.h"

namespace lumatlas {

// Returns the upward direction, unit: the one to which the cameras' x axes are most nearly perpendicular, because
// people hold cameras level. If the x axes leave it open, it is the mean of the cameras' upward axes. Throws
// std::invalid_argument for no camera.
[[nodiscard]] glm::dvec3 upward(std::span<const Camera> cameras);

// Returns the rotation after which `up` (unit) is +y, as in glTF and in most programs that read OBJ, and the cameras
// look along -z on average.
[[nodiscard]] glm::dmat3 upright(std::span<const Camera> cameras, const glm::dvec3& up);

}  // namespace lumatlas
