// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/layout/edge_distance.h"

#include <algorithm>
#include <cstddef>

namespace lumatlas {

std::vector<float> edge_distances(std::span<const std::uint8_t> good, std::uint32_t width, std::uint32_t height) {
  constexpr float kDiagonal = 1.41421356f;
  // With a frame of pixels around the image that may not be used.
  const std::size_t columns = std::size_t{width} + 2, rows = std::size_t{height} + 2;
  std::vector<float> framed(columns * rows, 0);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      if (good[y * width + x] != 0) framed[(y + 1) * columns + x + 1] = 1e9f;
    }
  }
  for (std::size_t y = 1; y + 1 < rows; ++y) {
    for (std::size_t x = 1; x + 1 < columns; ++x) {
      float* const p = &framed[y * columns + x];
      const float* const above = p - columns;
      *p = std::min({*p, p[-1] + 1, above[0] + 1, above[-1] + kDiagonal, above[1] + kDiagonal});
    }
  }
  for (std::size_t y = rows - 2; y > 0; --y) {
    for (std::size_t x = columns - 2; x > 0; --x) {
      float* const p = &framed[y * columns + x];
      const float* const below = p + columns;
      *p = std::min({*p, p[1] + 1, below[0] + 1, below[-1] + kDiagonal, below[1] + kDiagonal});
    }
  }
  std::vector<float> distances(std::size_t{width} * height);
  for (std::size_t y = 0; y < height; ++y) {
    std::copy_n(&framed[(y + 1) * columns + 1], width, &distances[y * width]);
  }
  return distances;
}

}  // namespace lumatlas
