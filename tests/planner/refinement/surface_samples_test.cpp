// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/surface_samples.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>

namespace lumatlas {
namespace {

// How many of the centres of the sampling image's pixels fall on each quarter of the photograph's pixels, along one
// axis, over the mean of the quarters: the least of the four.
double least_share_of_quarter(std::uint32_t photograph_px, std::uint32_t samples_px) {
  std::array<int, 4> quarters{};
  for (std::uint32_t i = 0; i < samples_px; ++i) {
    const double at = (i + 0.5) * photograph_px / samples_px;
    ++quarters[static_cast<std::size_t>(4 * (at - std::floor(at)))];
  }
  return 4.0 * *std::min_element(quarters.begin(), quarters.end()) / samples_px;
}

}  // namespace

TEST_CASE("samples fall on all places within a pixel, whatever the photograph's size", "[surface samples]") {
  for (std::uint32_t side = 100; side <= 6000; side += 7) {
    CAPTURE(side);
    CHECK(least_share_of_quarter(side, sampling_px(side, 320)) > 0.5);
  }
  for (const std::uint32_t side : {320u, 640u, 960u, 1280u, 1920u, 3840u}) {  // whole multiples
    CAPTURE(side);
    CHECK(least_share_of_quarter(side, sampling_px(side, 320)) > 0.5);
  }
}

TEST_CASE("the sampling image is never larger than asked for, nor than the photograph, nor much smaller",
          "[surface samples]") {
  for (const std::uint32_t most : {1u, 20u, 320u, 5000u}) {
    for (const std::uint32_t side : {1u, 2u, 48u, 320u, 321u, 1000u, 6000u}) {
      CAPTURE(most, side);
      const std::uint32_t found = sampling_px(side, most);
      CHECK(found >= 1);
      CHECK(found <= std::min(most, side));
      CHECK(found >= std::min(most, side) / 2);
    }
  }
}

}  // namespace lumatlas
