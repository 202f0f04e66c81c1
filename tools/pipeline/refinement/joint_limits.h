// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds what is looked at when poses or lenses of all stored views are solved for together, and what is said where
// that would take too long.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "planner/refinement/lens_estimate.h"

namespace lumatlas {

inline constexpr std::size_t kFewestJointPoints = 300;  // points of each view

// Returns what to tell where LensEstimates::too_many.
[[nodiscard]] inline std::string too_many_lenses(std::uint32_t views) {
  return std::to_string(views) + " stored views share points with too many others to estimate more than " +
         std::to_string(LensOptions{}.most_lenses) +
         " lenses: they stay as given; --max-views 400 keeps few enough, or give all photographs of a camera one lens";
}

// Returns how many points of each of `views` views (>= 1) to take, so that all together have about `points`.
[[nodiscard]] constexpr std::size_t points_of_each(std::size_t points, std::uint32_t views) {
  return std::max(kFewestJointPoints, points / views);
}

}  // namespace lumatlas
