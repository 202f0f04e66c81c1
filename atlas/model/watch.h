// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/.
#pragma once

#include <chrono>
#include <utility>

namespace lumatlas {

// Measures the steps of reading a model.
class Watch {
 public:
  // Returns the time since the last lap, or since this was made, milliseconds.
  double lap_ms() {
    const auto last = std::exchange(last_, std::chrono::steady_clock::now());
    return std::chrono::duration<double, std::milli>(last_ - last).count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace lumatlas
