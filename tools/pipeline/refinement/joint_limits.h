// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds what is looked at when poses or lenses of all stored views are solved for together, and what is said where
// that would take too long.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

namespace lumatlas {

inline constexpr std::size_t kFewestJointPoints = 300;  // points of each view
inline constexpr std::uint32_t kAlwaysTogether = 400;   // views that are few enough, whatever they show

// Returns what to tell where a solution for all views at once was PoseEstimate::too_large.
[[nodiscard]] inline std::string too_large_together(std::uint32_t views) {
  return std::to_string(views) +
         " stored views share points with too many others to solve for all poses and lenses at once: each view is "
         "refined beside its neighbours instead, which leaves a drift that many views share; --max-views " +
         std::to_string(kAlwaysTogether) + " keeps few enough";
}

// Returns what to tell where ShutterEstimate::too_large.
[[nodiscard]] inline std::string shutters_too_large(std::uint32_t views) {
  return std::to_string(views) +
         " stored views share points with too many others to look for motions while a shutter read them: photographs "
         "stay as they are; --max-views " +
         std::to_string(kAlwaysTogether) + " keeps few enough";
}

// Returns how many points of each of `views` views (>= 1) to take, so that all together have about `points`.
[[nodiscard]] constexpr std::size_t points_of_each(std::size_t points, std::uint32_t views) {
  return std::max(kFewestJointPoints, points / views);
}

}  // namespace lumatlas
