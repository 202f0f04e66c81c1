// SPDX-License-Identifier: GPL-3.0-or-later
// Medians and other percentiles.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace lumatlas {

// Returns the middle value, or the larger of the two middle values if their number is even. Reorders the values. There
// must be at least one, and none may be NaN.
template <typename Number>
[[nodiscard]] Number upper_median(std::vector<Number>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Returns the same, but the mean of the two middle values if their number is even.
[[nodiscard]] inline double median(std::vector<double>& values) {
  const double upper = upper_median(values);
  if (values.size() % 2 == 1) return upper;
  return 0.5 *
         (upper + *std::max_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2)));
}

// Returns the value below which the given share, in [0, 1], of the values lies; 0.5 gives the upper median. NaN without
// values.
[[nodiscard]] inline double percentile(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const std::size_t rank =
      std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank), values.end());
  return values[rank];
}

}  // namespace lumatlas
