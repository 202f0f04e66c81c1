// SPDX-License-Identifier: GPL-3.0-or-later
// The result of both renderers, the shader and its CPU reference.
#pragma once

#include <cstdint>
#include <vector>

#include "atlas/images/photograph.h"

namespace lumatlas {

// Why a pixel has its colour (paper Fig. 1 keeps unseen and untextured apart).
enum class PixelState : std::uint8_t {
  empty = 0,       // no surface: black
  unseen = 1,      // no view that was ever offered saw the cell: the vertex colour
  untextured = 2,  // the cell was seen, but no stored view is valid here: the vertex colour
  textured = 3,    // blended from stored views
};

struct Rendering {
  Photograph picture;             // sRGB
  std::vector<PixelState> state;  // one per pixel, row by row
};

// A picture in linear light, for those who go on computing with it.
struct LinearRendering {
  std::uint32_t width = 0;        // pixels
  std::uint32_t height = 0;       // pixels
  std::vector<float> rgb;         // 3 * width * height, >= 0; a gain may lift photographs above 1
  std::vector<PixelState> state;  // one per pixel, row by row
};

}  // namespace lumatlas
