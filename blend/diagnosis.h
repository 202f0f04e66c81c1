// SPDX-License-Identifier: GPL-3.0-or-later
// The views and weights behind each pixel of a picture, for people who want to know why it looks as it does.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "blend/rendering.h"
#include "mesh/base/id.h"

namespace lumatlas {

// The views that the pixel's own cell blends. Views of neighbouring cells, which are mixed in along its border
// (BlendOptions::border_width), are left out, also from the state.
struct PixelDiagnosis {
  // Number of views that the cell refers to and that are valid here, whatever their weight. Section 3.1's valid() > 0.
  std::uint32_t valid_views = 0;
  ViewSlot winner;  // the view slot of the view that weighs most; ViewSlot::none: none weighs anything
  // The weights of the three best views in the pixel's colour, best first, in [0, 1]. They sum to 1, to less where K is
  // above 3, and to 0 where there is no winner.
  std::array<float, 3> shares{};
};

// Row by row from the top left.
struct Diagnosis {
  std::uint32_t width = 0;   // pixels
  std::uint32_t height = 0;  // pixels
  std::vector<PixelState> state;
  std::vector<PixelDiagnosis> pixels;
};

}  // namespace lumatlas
