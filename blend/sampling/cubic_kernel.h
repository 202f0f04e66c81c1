// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: the cubic kernel that photographs are sampled with, between four pixels along each axis.
//
// A photograph's pixels are means over their areas, and linear interpolation between them blurs once more: by nothing
// at their middles, by half of their finest detail between them. Catmull and Rom's curve keeps most of that (R. Keys,
// "Cubic convolution interpolation for digital image processing", 1981, a = -1/2). Where a pixel of the picture covers
// more than one of the photograph it is mixed with the cubic B-spline, so that the kernel is as wide as that area:
//
//   k = (1 - b) Catmull-Rom + b B-spline,   b = (w^2 - 1) / 4 in [0, 1]     w: width covered, in pixels
//
// which are the kernels on the line 2 C + B = 1 of D. Mitchell and A. Netravali, "Reconstruction filters in computer
// graphics", 1988. Catmull-Rom's second moment is 0 and the B-spline's is 1/3, so that of k is what a mean over w
// pixels has more than a pixel: (w^2 - 1) / 12. Up to w = 2.2; beyond, coarser levels are sampled.
//
// The two middle weights have one sign for each k, so that the GPU's own filter can fetch their pixels as one, between
// them: 9 fetches in place of 16 (RendererOptions::filtered_taps). GPUs weigh the two in steps of 1/256. Along each
// axis, that is off by at most kFilterStep of the difference of both, in linear light.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "atlas/images/image_levels.h"
#include "atlas/tiles/tiles.h"

namespace lumatlas {

// Returns the weights of four pixels along an axis, for a position that lies `f` in [0, 1) behind the middle of the
// second. They sum to 1.
[[nodiscard]] inline std::array<double, 4> cubic_shares(double f, double width) {
  const double g = 1 - f;
  const std::array<double, 4> sharp{-f * g * g / 2, (f * f * (3 * f - 5) + 2) / 2, (g * g * (3 * g - 5) + 2) / 2,
                                    -g * f * f / 2};
  const std::array<double, 4> smoothing{g * g * g / 6, (f * f * (3 * f - 6) + 4) / 6, (g * g * (3 * g - 6) + 4) / 6,
                                        f * f * f / 6};
  const double b = std::clamp((width * width - 1) / 4, 0.0, 1.0);
  std::array<double, 4> shares{};
  for (std::size_t i = 0; i < 4; ++i) shares[i] = (1 - b) * sharp[i] + b * smoothing[i];
  return shares;
}

// (w1 + w2) / 512 is largest for Catmull and Rom's curve, half way between two pixels: 1.125 / 512.
inline constexpr double kFilterStep = 0.0022;

// Returns how many levels, finest first, are sampled cubically: those that have the two pixels beyond a tile that the
// kernel reaches. The coarsest level of a gutter has only one.
[[nodiscard]] inline std::uint32_t cubic_levels(const TileOptions& options) {
  return levels_of_gutter(options.gutter_px) - 1;
}

}  // namespace lumatlas
