// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "atlas/images/srgb.h"

namespace lumatlas {

struct Oklab {
  double lightness, a, b;
};

// From 8-bit sRGB: the forward transform, which the program does not hold.
inline Oklab oklab(const std::array<std::uint8_t, 3>& color) {
  const auto light = [](std::uint8_t level) { return linear_from_srgb(level / 255.0); };
  const double r = light(color[0]);
  const double g = light(color[1]);
  const double b = light(color[2]);
  const double l = std::cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const double m = std::cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const double s = std::cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return {0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
          1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
          0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s};
}

}  // namespace lumatlas
