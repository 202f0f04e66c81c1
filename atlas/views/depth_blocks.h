// SPDX-License-Identifier: GPL-3.0-or-later
// A stored view's depth as the renderer's textures hold it: what decides whether the view sees a point, in a quarter of
// a byte a pixel.
//
// The reciprocal of a plane's depth is linear across an image. So a block of 8 x 8 pixels is a plane, or where one does
// not fit, two parallel ones and for each pixel which of them it shows; and which pixels are at rims. Depths are shares
// of depth_scale(). With (x, y) in pixels from the block's middle, 1 / depth = a (1 + b x + c y), in four words of 32
// bits, the lowest bits first:
//
//   one plane     a in half precision, 15 bits of 0, whole; b, c as 16-bit shares of kMostDepthSlope; a bit a pixel: at
//                 a rim
//   two planes    -a of the nearer, a of the farther in half precision, without its sign, whole; b, c in 8 bits, the
//                 root of their share of kMostDepthSlope with their sign; a bit for each 2 x 2 pixels: at a rim; a bit
//                 a pixel: the farther
//
// Pixels are counted row by row from the top left. A reciprocal of 0 or less is of nothing that hides anything. The bit
// `whole` says that the block's pixels and those next to them are wholly valid, so that the shader need not look up
// their validity.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "atlas/tiles/texel_format.h"
#include "atlas/views/stored_view.h"

namespace lumatlas {

inline constexpr double kMostDepthSlope = 0.125;  // largest b and c, per pixel; steeper slopes are cut to it

using DepthBlock = std::array<std::uint32_t, 4>;
inline constexpr std::uint32_t kWholeBit = 0x80000000;  // of the first word

// A power of two near the median of the view's depths; 1 if it has none.
[[nodiscard]] float depth_scale(const StoredView& view);

// Returns the block whose first pixel is (x, y). Pixels beyond the image are empty. Pixels that the view's validity
// leaves out, and their neighbours, are not kept while there are others. The others are shown at their depth or behind
// it, so that no view finds what it shows hidden. tools/viewer/page/shaders/depth.frag does the same.
[[nodiscard]] DepthBlock depth_block(const StoredView& view, std::uint32_t x, std::uint32_t y, float scale);

// The block's value at the middle of its pixel `number`.
struct BlockPixel {
  double reciprocal = 0;  // 1 / depth, in the view's unit
  bool at_rim = false;
};
[[nodiscard]] BlockPixel decoded(const DepthBlock& block, std::uint32_t number, float scale);

// Returns what the texture array holds for each pixel of a view, row by row from the top left.
[[nodiscard]] std::vector<BlockPixel> shown_depths(const StoredView& view);

}  // namespace lumatlas
