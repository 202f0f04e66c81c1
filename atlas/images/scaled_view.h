// SPDX-License-Identifier: GPL-3.0-or-later
// Stored views in the size in which a page gets them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "atlas/views/stored_view.h"

namespace lumatlas {

// The largest side of a texture that every WebGL 2 takes, and so the longest side of a photograph in a page.
inline constexpr std::uint32_t kMostSidePx = 2048;

// A view's photograph, and what is valid of it. Row by row.
struct ScaledView {
  std::uint32_t width = 0, height = 0;  // pixels; the last column and row may be wider than the picture
  Photograph photograph;
  std::vector<std::uint8_t> validity;
  std::vector<std::uint8_t> rim;
};

// Pixels are means over the area that they cover, in linear light and by validity, as coarser levels are
// (atlas/images/image_levels.h); a pixel is at a rim if the one at its middle is. A factor of 1 changes nothing. Throws
// std::invalid_argument unless the factor is in (0, 1].
[[nodiscard]] ScaledView scaled_view(const StoredView& view, double factor);

// A small picture of a photograph, in which validity does not matter, its longer side at most so long. What is in a
// tile that is not there, of tiles of `tile_px` row by row, becomes what its neighbourhood is; none are given: all are
// there.
[[nodiscard]] Photograph small_picture(const StoredView& view, std::uint32_t longest_px,
                                       std::span<const std::uint8_t> tiles_there = {}, std::uint32_t tile_px = 0);

}  // namespace lumatlas
