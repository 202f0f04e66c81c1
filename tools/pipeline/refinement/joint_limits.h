// SPDX-License-Identifier: GPL-3.0-or-later
// How much is looked at when poses or lenses of all stored views are solved for together.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace lumatlas {

// Time grows with the cube of this: some ten seconds.
inline constexpr std::uint32_t kMostJointViews = 400;
inline constexpr std::size_t kFewestJointPoints = 300;  // of each view

[[nodiscard]] constexpr bool can_be_solved_for_together(std::uint32_t views) {
  return views > 0 && views <= kMostJointViews;
}

// What to tell of so many views, if they are too many.
[[nodiscard]] inline std::optional<std::string> too_many_together(std::uint32_t views) {
  if (views <= kMostJointViews) return std::nullopt;
  return std::to_string(views) + " stored views are too many to solve for all poses and lenses at once (at most " +
         std::to_string(kMostJointViews) +
         "): each view is refined beside its neighbours instead, which leaves a drift that many views share; "
         "--max-views " +
         std::to_string(kMostJointViews) + " keeps few enough";
}

// Of each view, so that it is about so many of all together.
[[nodiscard]] constexpr std::size_t points_of_each(std::size_t points, std::uint32_t views) {
  return std::max(kFewestJointPoints, points / views);
}

}  // namespace lumatlas
