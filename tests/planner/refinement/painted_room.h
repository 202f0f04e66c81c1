// SPDX-License-Identifier: GPL-3.0-or-later
// A room whose colour is known at each point, and photographs of it that are bent in any way.
#pragma once

#include <cstddef>
#include <functional>
#include <glm/vec2.hpp>

#include "atlas/images/photograph.h"
#include "mesh/camera/camera.h"
#include "mesh/visibility/visibility.h"
#include "planner/planner.h"

namespace lumatlas {

[[nodiscard]] Camera painted_camera(std::size_t number);

// A photograph each of whose pixels shows what a pinhole camera would show at `shown`(pixel), which may lie up to 20
// pixels beside its picture.
[[nodiscard]] Photograph painted_photograph(const Camera& camera, const Visibility& visibility,
                                            const std::function<glm::dvec2(const glm::dvec2& pixel)>& shown);

// For photographs of the room, all of which are kept, without masks.
[[nodiscard]] PlannerOptions painted_room_planner();

}  // namespace lumatlas
