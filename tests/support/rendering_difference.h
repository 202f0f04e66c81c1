// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <catch2/catch.hpp>
#include <cstdlib>

#include "blend/rendering.h"

namespace lumatlas {

// The share of pixels in which any channel differs by more than `levels` of 255, or the state differs.
inline double share_different(const Rendering& a, const Rendering& b, int levels) {
  REQUIRE(a.state.size() == b.state.size());
  std::size_t different = 0;
  for (std::size_t pixel = 0; pixel < a.state.size(); ++pixel) {
    bool differs = a.state[pixel] != b.state[pixel];
    for (std::size_t channel = 0; channel < 3; ++channel) {
      differs |= std::abs(a.picture.rgb[3 * pixel + channel] - b.picture.rgb[3 * pixel + channel]) > levels;
    }
    different += differs;
  }
  return static_cast<double>(different) / static_cast<double>(a.state.size());
}

}  // namespace lumatlas
