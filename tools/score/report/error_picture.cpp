// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/report/error_picture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "tools/score/measures/counted_pixels.h"
#include "tools/score/report/color_map.h"

namespace lumatlas {

namespace {

// The sum over the channels of the squared differences: a whole number, so the colours of all of them are a table.
constexpr int kFullScaleSquares = static_cast<int>(3 * kErrorFullScale * kErrorFullScale);

std::vector<std::array<std::uint8_t, 3>> color_of_squares() {
  std::vector<std::array<std::uint8_t, 3>> table;
  for (int squares = 0; squares <= kFullScaleSquares; ++squares) {
    table.push_back(error_color(std::sqrt(squares / 3.0)));
  }
  return table;
}

int difference_squares(const std::uint8_t* a, const std::uint8_t* b) {
  int squares = 0;
  for (int channel = 0; channel < 3; ++channel) {
    const int difference = int{a[channel]} - int{b[channel]};
    squares += difference * difference;
  }
  return squares;
}

}  // namespace

std::array<std::uint8_t, 3> error_color(double levels) {
  return error_ramp(levels / kErrorFullScale);
}

Photograph error_picture(const Photograph& rendering, const Photograph& photograph,
                         std::span<const std::uint8_t> mask) {
  const CountedPixels counted = counted_pixels(rendering, photograph, mask);
  static const std::vector<std::array<std::uint8_t, 3>> colors = color_of_squares();
  Photograph picture;
  picture.width = photograph.width;
  picture.height = photograph.height;
  picture.rgb.resize(photograph.rgb.size());
  for (std::size_t i = 0; i < counted.size(); ++i) {
    std::array<std::uint8_t, 3> color = kNotScoredColor;
    if (counted[i] != 0) {
      const int squares = difference_squares(&rendering.rgb[3 * i], &photograph.rgb[3 * i]);
      color = colors[static_cast<std::size_t>(std::min(squares, kFullScaleSquares))];
    }
    std::copy(color.begin(), color.end(), picture.rgb.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }
  return picture;
}

}  // namespace lumatlas
