// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds what is looked at when poses or lenses of all stored views are solved for together, and what is said where
// that would take too long.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

namespace lumatlas {

inline constexpr std::size_t kFewestJointPoints = 300;     // points of each view
inline constexpr std::uint32_t kFewEnoughForLenses = 800;  // views, whatever they show

// Returns what to tell where LensEstimates::too_large.
[[nodiscard]] inline std::string too_large_for_lenses(std::uint32_t views) {
  return std::to_string(views) +
         " stored views share points with too many others to estimate their lenses, which stay as given; --max-views " +
         std::to_string(kFewEnoughForLenses) + " keeps few enough";
}

// Returns how many points of each of `views` views (>= 1) to take, so that all together have about `points`.
[[nodiscard]] constexpr std::size_t points_of_each(std::size_t points, std::uint32_t views) {
  return std::max(kFewestJointPoints, points / views);
}

}  // namespace lumatlas
