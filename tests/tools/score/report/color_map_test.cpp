// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/report/color_map.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/support/oklab.h"

namespace lumatlas {
namespace {

double difference(const Rgb8& x, const Rgb8& y) {
  const Oklab p = oklab(x);
  const Oklab q = oklab(y);
  return std::hypot(p.lightness - q.lightness, p.a - q.a, p.b - q.b);
}

TEST_CASE("perceived lightness grows in proportion on both ramps") {
  const auto ramp = GENERATE(&error_ramp, &quantity_ramp);
  const double dark = oklab(ramp(0)).lightness;
  const double bright = oklab(ramp(1)).lightness;
  CHECK(bright - dark > 0.6);
  for (int step = 0; step <= 200; ++step) {
    CAPTURE(step);
    // Rounding to 8 bits moves dark colours by up to .01; clipping into sRGB would move them further.
    CHECK(oklab(ramp(step / 200.0)).lightness == Approx(dark + (bright - dark) * step / 200).margin(0.015));
  }
}

TEST_CASE("equal steps of a quantity look equally different, and the ramp ends in violet and yellow") {
  for (int step = 0; step < 20; ++step) {
    CAPTURE(step);
    const double apart = difference(quantity_ramp(step / 20.0), quantity_ramp((step + 1) / 20.0));
    CHECK(apart > 0.03);  // lightness alone
    CHECK(apart < 0.07);
  }
  CHECK(quantity_ramp(0)[2] > 2 * quantity_ramp(0)[1]);
  CHECK(quantity_ramp(1)[0] > 200);
  CHECK(quantity_ramp(1)[2] < 150);
}

TEST_CASE("parts outside of the range have the colours of its ends") {
  CHECK(quantity_ramp(-3) == quantity_ramp(0));
  CHECK(quantity_ramp(7) == quantity_ramp(1));
  CHECK(quantity_ramp(std::numeric_limits<double>::infinity()) == quantity_ramp(1));
  CHECK(quantity_ramp(std::nan("")) == quantity_ramp(0));
}

TEST_CASE("numbers that are close have colours that are not") {
  // In Oklab .02 is about what can just be told apart side by side.
  for (std::uint32_t number = 0; number < 3000; ++number) {
    for (std::uint32_t other = number + 1; other < number + 10; ++other) {
      REQUIRE(difference(distinct_color(number), distinct_color(other)) > 0.03);
    }
  }
  CHECK(distinct_color(4294967295u) == distinct_color(4294967295u));
}

}  // namespace
}  // namespace lumatlas
