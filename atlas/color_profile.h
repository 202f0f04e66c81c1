// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: from the colours that a file's ICC profile describes to sRGB.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace lumatlas {

// Converts `rgb`, three values a pixel, from the colours of `profile`, the bytes of an ICC profile of RGB or grey, to
// sRGB: relative colorimetric, and what sRGB cannot show is clipped. Pixels stay as they are, to the byte, where the
// profile is sRGB within two levels, where it is of another kind (CMYK), and where it is no sound profile: then they
// are taken as sRGB, as every viewer does. Of a grey profile each pixel's red is taken.
void convert_to_srgb(std::span<const std::uint8_t> profile, std::vector<std::uint8_t>& rgb);

}  // namespace lumatlas
