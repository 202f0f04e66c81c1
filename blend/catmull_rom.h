// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: cubic convolution between pixels. R. Keys, "Cubic convolution interpolation for digital image
// processing", 1981, with a = -1/2, which is Catmull and Rom's curve.
//
// A photograph's pixels are means over their areas already, and linear interpolation between them blurs once more: by
// nothing at their middles, by half of their finest detail between them. Cubic convolution keeps most of that.
#pragma once

#include <array>

#include "atlas/tiles.h"

namespace lumatlas {

// Of the pixels one before, at, one after and two after a place `f` in [0, 1) behind the middle of one; sum 1. They
// give back polynomials of degree 2 exactly.
[[nodiscard]] inline std::array<double, 4> catmull_rom(double f) {
  return {f * (f * (2 - f) - 1) / 2, (f * f * (3 * f - 5) + 2) / 2, f * (f * (4 - 3 * f) + 1) / 2, f * f * (f - 1) / 2};
}

// Whether photographs that are stored so have the two pixels beyond a tile that this takes.
[[nodiscard]] inline bool has_room_for_cubic(const TileOptions& options) {
  return options.gutter_px >= 2;
}

}  // namespace lumatlas
