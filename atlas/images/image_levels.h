// SPDX-License-Identifier: GPL-3.0-or-later
// A part of a stored view as texels, with coarser levels for cameras that are farther away than it.
#pragma once

#include <cstdint>
#include <vector>

#include "atlas/views/stored_view.h"

namespace lumatlas {

// A part of a view, in pixels. It may reach beyond the image, where the pixels at the image's border are repeated.
struct ImageRect {
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};

// One level as texels, row by row from the top left; each is sRGB and validity, 8 bit a channel.
struct ImageLevel {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint8_t> rgba;
};

// Number of levels of a photograph with this gutter around its parts, the finest included.
[[nodiscard]] std::uint32_t levels_of_gutter(std::uint32_t gutter_px);

// The finest level is the view's pixels. A texel of the next one is the mean of four, in linear light and by their
// validity, so that what may not be shown does not bleed into it. The sides of `rect` must be multiples of
// 2^(levels - 1) and the view's photograph and validity as large as its camera says (std::invalid_argument).
[[nodiscard]] std::vector<ImageLevel> image_levels(const StoredView& view, const ImageRect& rect, std::uint32_t levels);
// Makes the coarser levels of a finest level that the caller has.
[[nodiscard]] std::vector<ImageLevel> with_coarser_levels(ImageLevel finest, std::uint32_t levels);

}  // namespace lumatlas
