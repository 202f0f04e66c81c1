// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/pipeline/: finds how much detail a photograph lost to motion or to a wrong focus, so that the
// planner keeps a sharp one where it has the choice. The paper takes all photographs as equally sharp.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "atlas/images/photograph.h"
#include "mesh/camera/camera.h"

namespace lumatlas {

// Returns the logarithm of the finest detail of a photograph as a share of the detail twice as coarse, both as roots of
// mean squares of brightness, at a longer side of 640 to 960 pixels or its own if that is less. It depends on what the
// photograph shows too. None for a photograph without any detail.
[[nodiscard]] std::optional<double> fine_detail(const Photograph& photograph);

// Returns how sharp each photograph is, in (0, 1]. A twentieth of all photographs, 20 at most, those that were taken
// from nearest by in nearly the same direction, are taken to show much the same; it is compared with the sharpest fifth
// of them. Detail that is a twelfth less, as other content may have, counts as sharp. `fine_detail` has one for each
// camera (std::invalid_argument); 1 for a photograph of which it is not known.
[[nodiscard]] std::vector<double> relative_sharpness(std::span<const Camera> cameras,
                                                     std::span<const std::optional<double>> fine_detail);

}  // namespace lumatlas
