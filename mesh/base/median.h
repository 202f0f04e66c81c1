// SPDX-License-Identifier: GPL-3.0-or-later
// Medians and other percentiles.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace lumatlas {

// The middle value, of an even number the larger of the two. Reorders the values, of which there must be one, and none
// of them NaN.
template <typename Number>
[[nodiscard]] Number upper_median(std::vector<Number>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The same, but of an even number the mean of the two.
[[nodiscard]] inline double median(std::vector<double>& values) {
  const double upper = upper_median(values);
  if (values.size() % 2 == 1) return upper;
  return 0.5 *
         (upper + *std::max_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2)));
}

// The value that a share, in [0, 1], of the values is below; 0.5: the upper median. NaN if there are none.
[[nodiscard]] inline double percentile(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const std::size_t rank =
      std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank), values.end());
  return values[rank];
}

}  // namespace lumatlas
