// SPDX-License-Identifier: GPL-3.0-or-later
// The properties of a video frame by which frames are chosen.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec2.hpp>

namespace lumatlas {

// The frame is divided into a grid of equal parts, row by row from the top left.
inline constexpr std::size_t kFlowColumns = 4, kFlowRows = 4, kFlowParts = kFlowColumns * kFlowRows;

struct VideoFrame {
  double sharpness = 0;  // variance of the Laplacian of the grey values, >= 0: comparable between frames of one view
  // The share of the corners of the frame before that are found again in this one, [0, 1]. Little is left after a cut.
  double found_again = 1;
  // Movement of each part's content since the frame before, as a share of the frame's longer side.
  std::array<glm::vec2, kFlowParts> flow{};
};

}  // namespace lumatlas
