// SPDX-License-Identifier: GPL-3.0-or-later
// A wall of squares of grey by chance, as a camera that moves along it sees it.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "atlas/images/photograph.h"

namespace lumatlas {

class TexturedWall {
 public:
  explicit TexturedWall(unsigned seed) : squares_(kSide * kSide) {
    std::mt19937 random(seed);
    for (double& square : squares_) square = static_cast<double>(random() % 256);
  }

  // Grey values from `left` and `top` on, in pixels; smooth, so that parts of a pixel count.
  [[nodiscard]] std::vector<std::uint8_t> grey(std::uint32_t width, std::uint32_t height, double left,
                                               double top) const {
    std::vector<std::uint8_t> values;
    for (std::uint32_t y = 0; y < height; ++y) {
      for (std::uint32_t x = 0; x < width; ++x) {
        values.push_back(static_cast<std::uint8_t>(std::lround(value(left + x, top + y))));
      }
    }
    return values;
  }

  [[nodiscard]] Photograph photograph(std::uint32_t width, std::uint32_t height, double left, double top) const {
    Photograph result{width, height, {}, {}};
    for (const std::uint8_t value : grey(width, height, left, top)) {
      // A warm grey, so that wrong colours are seen.
      result.rgb.insert(result.rgb.end(),
                        {value, static_cast<std::uint8_t>(value * 3 / 4), static_cast<std::uint8_t>(value / 2)});
    }
    return result;
  }

 private:
  static constexpr std::size_t kSide = 128;
  static constexpr double kSquare = 12;  // pixels

  [[nodiscard]] double value(double x, double y) const {
    const double column = x / kSquare, row = y / kSquare;
    const auto c = static_cast<std::size_t>(column), r = static_cast<std::size_t>(row);
    const double right = column - std::floor(column), down = row - std::floor(row);
    const auto at = [&](std::size_t i, std::size_t j) { return squares_[i % kSide * kSide + j % kSide]; };
    return (at(r, c) * (1 - right) + at(r, c + 1) * right) * (1 - down) +
           (at(r + 1, c) * (1 - right) + at(r + 1, c + 1) * right) * down;
  }

  std::vector<double> squares_;
};

}  // namespace lumatlas
