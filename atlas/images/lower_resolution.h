// SPDX-License-Identifier: GPL-3.0-or-later
// Shrinks photographs.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "atlas/images/photograph.h"

namespace lumatlas {

// Returns the picture at `width` x `height` pixels, filtered in linear light from the pixels that the lens saw. It
// works in bands, so that it takes some 40 MB besides both pictures, however large they are. A pixel is valid if no
// part of it lies outside the lens's image. Throws std::invalid_argument unless both are in [1, the photograph's] and
// the photograph has three values a pixel of colour and one, or none, of the lens's image.
[[nodiscard]] Photograph at_lower_resolution(const Photograph& photograph, std::uint32_t width, std::uint32_t height);

// A mask of one value a pixel, of which each result is the mean of what it covers; empty stays empty. The rules for
// sizes are those above.
[[nodiscard]] std::vector<std::uint8_t> mask_at_lower_resolution(std::span<const std::uint8_t> mask, ImageSize from,
                                                                 ImageSize to);

}  // namespace lumatlas
