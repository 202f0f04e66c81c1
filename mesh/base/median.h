// SPDX-License-Identifier: GPL-3.0-or-later
// Medians of numbers that may be reordered.
#pragma once

#include <algorithm>
#include <cstddef>
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

}  // namespace lumatlas
