// SPDX-License-Identifier: GPL-3.0-or-later
// Draws the difference between a rendering and the photograph: dark is right, bright is wrong.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "atlas/images/photograph.h"

namespace lumatlas {

// The difference of a pixel is the root mean square over R, G and B of the sRGB differences, in 8-bit levels: what PSNR
// adds up. From this many levels on it has the brightest colour (a quarter of the range: amplified four times).
inline constexpr double kErrorFullScale = 64;

// The colour of a difference in levels: see error_ramp().
[[nodiscard]] std::array<std::uint8_t, 3> error_color(double levels);

// A pixel that does not count (mask and photograph.valid as in scores.h) has this colour, which no difference has.
inline constexpr std::array<std::uint8_t, 3> kNotScoredColor = {112, 128, 132};

// Throws std::invalid_argument as scores.h does.
[[nodiscard]] Photograph error_picture(const Photograph& rendering, const Photograph& photograph,
                                       std::span<const std::uint8_t> mask);

}  // namespace lumatlas
