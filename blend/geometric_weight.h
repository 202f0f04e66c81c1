// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: how like the novel view a stored one is, seen from a point.
#pragma once

#include <glm/vec3.hpp>

#include "blend/blend_options.h"

namespace lumatlas {

// lambda w_dir + (1 - lambda) w_pos of blend_options.h, in [0, 1]; 0 at the place of either camera.
[[nodiscard]] double geometric_weight(const glm::dvec3& world, const glm::dvec3& novel_center,
                                      const glm::dvec3& stored_center, const BlendOptions& options);

// The factor of a view's weight where the point is at a rim of what it sees (rim_pixels()), in [0, 1]: 1
// if the two cameras see the point from directions within kRimNearDegrees of each other, 0 beyond kRimFarDegrees and
// where the options leave rims out.
[[nodiscard]] double rim_share(const glm::dvec3& world, const glm::dvec3& novel_center, const glm::dvec3& stored_center,
                               const BlendOptions& options);

}  // namespace lumatlas
