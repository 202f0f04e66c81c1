// SPDX-License-Identifier: GPL-3.0-or-later
// Finds how many steps stay within a bound, if each try takes long.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>

namespace lumatlas {

// Returns the most steps, fewer than `too_far`, that lose no more than the bound, to within `close_enough` (>= 1)
// steps. Stops early where four fifths of the bound are used up. loss_at(steps) should rise about as the square of the
// steps, by which the next try is chosen, away from the ends of the interval in case it rises otherwise. 0 steps lose
// nothing.
[[nodiscard]] inline std::size_t most_steps_within(double max_loss_db, std::size_t too_far, std::size_t close_enough,
                                                   const std::function<double(std::size_t)>& loss_at) {
  constexpr double kUsedUp = 0.8;  // share of the bound
  constexpr double kFarthest = 4;  // times as many steps as were tried last
  std::size_t fits = 0, guess = too_far / 2;
  while (too_far - fits > close_enough) {
    const std::size_t margin = (too_far - fits) / 8;
    const std::size_t least = fits + std::max<std::size_t>(1, margin);
    const std::size_t now = std::clamp(guess, least, std::max(least, too_far - margin - 1));
    const double loss_db = loss_at(now);
    (loss_db <= max_loss_db ? fits : too_far) = now;
    if (fits == now && loss_db >= kUsedUp * max_loss_db) break;
    const double times = loss_db > 0 ? std::sqrt(std::max(max_loss_db, 0.0) / loss_db) : kFarthest;
    guess = static_cast<std::size_t>(static_cast<double>(now) * std::min(times, kFarthest));
  }
  return fits;
}

}  // namespace lumatlas
