// SPDX-License-Identifier: GPL-3.0-or-later
// The sRGB transfer function (IEC 61966-2-1). Photographs and pictures are sRGB; exposure and blending act in linear
// light.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace lumatlas {

// Both functions map [0, 1] to [0, 1].
[[nodiscard]] inline double linear_from_srgb(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}
[[nodiscard]] inline double srgb_from_linear(double linear) {
  return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

// The nearest 8-bit value; clamps to [0, 1] first.
[[nodiscard]] inline std::uint8_t srgb8_from_linear(double linear) {
  return static_cast<std::uint8_t>(std::lround(255 * srgb_from_linear(std::clamp(linear, 0.0, 1.0))));
}

// Linear light of every 8-bit value.
[[nodiscard]] inline const std::array<float, 256>& linear_from_srgb8() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = static_cast<float>(linear_from_srgb(static_cast<double>(i) / 255));
    return values;
  }();
  return table;
}

}  // namespace lumatlas
