// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: from the colours that a file's ICC profile describes to sRGB.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace lumatlas {

// Converts `rgb`, three values a pixel, from the colours of `profile`, the bytes of an ICC profile of RGB or grey, to
// sRGB: relative colorimetric, and what sRGB cannot show is clipped. All pixels stay as they are, to the byte, and so
// are taken as sRGB, if the profile is
//   - sRGB within two levels,
//   - of another kind, such as CMYK,
//   - one of grey, and not every pixel has three equal values,
//   - damaged.
void convert_to_srgb(std::span<const std::uint8_t> profile, std::vector<std::uint8_t>& rgb);

struct Chromaticity {
  double x, y;  // CIE 1931
};
struct Primaries {
  Chromaticity red, green, blue, white;
};
// Makes the ICC profile of colours with these primaries and the curve of sRGB. Empty where there is no such space.
[[nodiscard]] std::vector<std::uint8_t> profile_of(const Primaries& primaries);

}  // namespace lumatlas
