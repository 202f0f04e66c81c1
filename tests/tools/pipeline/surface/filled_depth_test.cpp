// SPDX-License-Identifier: GPL-3.0-or-later
// Tests how inverse depths are continued into pixels of which nothing is known.
#include "tools/pipeline/surface/filled_depth.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

namespace lumatlas {
namespace {

constexpr std::uint32_t kColumns = 37, kRows = 23;

// Inverse depths of a picture of this size; those of the columns [first, last) are not known.
template <typename Depth>
std::vector<double> with_gap(std::uint32_t first, std::uint32_t last, const Depth& depth) {
  std::vector<double> inverse;
  for (std::uint32_t y = 0; y < kRows; ++y) {
    for (std::uint32_t x = 0; x < kColumns; ++x) inverse.push_back(x >= first && x < last ? 0 : 1 / depth(x, y));
  }
  return inverse;
}

TEST_CASE("known inverse depths stay, and a gap in a wall gets the wall's") {
  const std::vector<double> wall = with_gap(12, 21, [](auto, auto) { return 4.0; });
  for (const double inverse : filled_inverse_depth(wall, kColumns, kRows)) CHECK(inverse == Approx(0.25));

  const std::vector<double> slope = with_gap(12, 21, [](auto x, auto y) { return 3 + 0.1 * x + 0.05 * y; });
  const std::vector<double> filled = filled_inverse_depth(slope, kColumns, kRows);
  const auto [least, most] = std::minmax_element(filled.begin(), filled.end());
  for (std::size_t pixel = 0; pixel < slope.size(); ++pixel) {
    if (slope[pixel] > 0) {
      CHECK(filled[pixel] == slope[pixel]);
    } else {
      const std::size_t x = pixel % kColumns, y = pixel / kColumns;
      const double truth = 1 / (3 + 0.1 * static_cast<double>(x) + 0.05 * static_cast<double>(y));
      CHECK(std::abs(filled[pixel] / truth - 1) < 0.15);
    }
  }
  CHECK(1 / *most == Approx(3));
  CHECK(1 / *least == Approx(3 + 0.1 * (kColumns - 1) + 0.05 * (kRows - 1)));
}

TEST_CASE("beside an object, what is behind it goes on") {
  const std::vector<double> step = with_gap(16, 20, [](auto x, auto) { return x < 16 ? 2.0 : 10.0; });
  const std::vector<double> filled = filled_inverse_depth(step, kColumns, kRows);
  for (std::uint32_t x = 16; x < 20; ++x) CHECK(1 / filled[10 * kColumns + x] > 6);
}

TEST_CASE("one known pixel fills a picture, none leaves it unknown") {
  std::vector<double> one(std::size_t{kColumns} * kRows);
  CHECK(filled_inverse_depth(one, kColumns, kRows) == one);
  one[100] = 0.5;
  for (const double inverse : filled_inverse_depth(one, kColumns, kRows)) CHECK(inverse == Approx(0.5));
  const std::vector<double> row{0, 0.25, 0};
  CHECK(filled_inverse_depth(row, 3, 1) == std::vector<double>{0.25, 0.25, 0.25});
}

TEST_CASE("inverse depths that are not one per pixel are refused") {
  const std::vector<double> row{1, 1, 1};
  CHECK_THROWS_AS(filled_inverse_depth(row, 2, 1), std::invalid_argument);
  CHECK_THROWS_AS(filled_inverse_depth(row, 3, 0), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
