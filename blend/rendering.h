// SPDX-License-Identifier: GPL-3.0-or-later
// What both renderers, the shader and its CPU reference, return.
#pragma once

#include <cstdint>
#include <vector>

#include "atlas/photograph.h"

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

}  // namespace lumatlas
