// SPDX-License-Identifier: GPL-3.0-or-later
// Colours for what is not a colour: errors, quantities, numbers of things. All are 8-bit sRGB.
#pragma once

#include <array>
#include <cstdint>

namespace lumatlas {

using Rgb8 = std::array<std::uint8_t, 3>;

// Both take a part in [0, 1], others as the nearer of the two, NaN as 0. Perceived lightness (L of Oklab) grows in
// proportion to it, so the pictures read in grey and to the colour-blind too.
[[nodiscard]] Rgb8 error_ramp(double part);     // from black over violet, red and orange to pale yellow
[[nodiscard]] Rgb8 quantity_ramp(double part);  // from dark violet over blue and green to yellow

// The same for a number wherever it is asked for; numbers that differ by less than ten are plainly different colours.
[[nodiscard]] Rgb8 distinct_color(std::uint32_t number);

}  // namespace lumatlas
