// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the upward direction of a scene from its cameras, and the rotation that makes the scene upright.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>

#include "mesh/camera.h"

namespace lumatlas {

// Unit. The direction that the cameras' x axes are most nearly at right angles to, for people hold cameras level; where
// these leave it open, the mean of what is upwards in the pictures. At least one camera (std::invalid_argument).
[[nodiscard]] glm::dvec3 upward(std::span<const Camera> cameras);

// The rotation after which `up` (unit) is +y, as glTF and most programs that read OBJ have it, and the cameras look
// along -z on average.
[[nodiscard]] glm::dmat3 upright(std::span<const Camera> cameras, const glm::dvec3& up);

}  // namespace lumatlas
