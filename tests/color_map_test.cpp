// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/color_map.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

namespace lumatlas {
namespace {

double linear_light(std::uint8_t level) {
  const double srgb = level / 255.0;
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

struct Oklab {
  double lightness, a, b;
};

// From 8-bit sRGB: the forward transform, which the module does not hold.
Oklab oklab(const Rgb8& color) {
  const double r = linear_light(color[0]);
  const double g = linear_light(color[1]);
  const double b = linear_light(color[2]);
  const double l = std::cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const double m = std::cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const double s = std::cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return {0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
          1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
          0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s};
}

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
