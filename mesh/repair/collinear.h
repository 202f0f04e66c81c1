// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: whether a face has no area, decided exactly.
#pragma once

#include <glm/vec3.hpp>

namespace lumatlas {

// Returns whether the three finite points lie on one line.
[[nodiscard]] bool are_collinear(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c);

}  // namespace lumatlas
