// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/layout/edge_distance.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace lumatlas {
namespace {

TEST_CASE("the image's border is an edge") {
  const std::vector<float> distances = edge_distances(std::vector<std::uint8_t>(5 * 3, 1), 5, 3);
  CHECK(distances == std::vector<float>{1, 1, 1, 1, 1, 1, 2, 2, 2, 1, 1, 1, 1, 1, 1});
}

TEST_CASE("distances are the true ones within 8.3 percent") {
  constexpr std::uint32_t kWidth = 37, kHeight = 29;
  std::mt19937 random(5);
  std::vector<std::uint8_t> good(std::size_t{kWidth} * kHeight);
  for (std::uint8_t& pixel : good) pixel = std::uniform_int_distribution<int>(0, 199)(random) != 0;
  const std::vector<float> distances = edge_distances(good, kWidth, kHeight);
  for (std::uint32_t y = 0; y < kHeight; ++y) {
    for (std::uint32_t x = 0; x < kWidth; ++x) {
      double least = std::min({x + 1, y + 1, kWidth - x, kHeight - y});
      for (std::uint32_t v = 0; v < kHeight; ++v) {
        for (std::uint32_t u = 0; u < kWidth; ++u) {
          if (!good[v * kWidth + u]) least = std::min(least, std::hypot(1.0 * u - x, 1.0 * v - y));
        }
      }
      const double found = static_cast<double>(distances[y * kWidth + x]);
      REQUIRE(found >= least - 1e-4);
      REQUIRE(found <= 1.083 * least + 1e-4);  // the octagon's corners, Borgefors 1986
    }
  }
}

}  // namespace
}  // namespace lumatlas
