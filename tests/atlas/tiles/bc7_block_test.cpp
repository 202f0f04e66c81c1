// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/tiles/bc7_block.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <stdexcept>

namespace lumatlas {
namespace {

BlockTexels through(const BlockTexels& texels) {
  return texels_of(bc7_block(texels));
}

double squared_error(const BlockTexels& a, const BlockTexels& b) {
  double sum = 0;
  for (std::size_t i = 0; i < kBc7BlockTexels; ++i) {
    for (std::size_t channel = 0; channel < 4; ++channel) sum += std::pow(int{a[i][channel]} - int{b[i][channel]}, 2);
  }
  return sum;
}

TEST_CASE("blocks are laid out as the specification says") {
  BlockTexels white{};
  white.fill({255, 255, 255, 255});
  // Mode 6 is bit 6 alone; then all of both ends, 56 bits and the two lowest, are 1, and all codes 0.
  CHECK(bc7_block(white) == Bc7Block{0xC0, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x01});
  // Mode 4: red from 0 to 255, alpha from 255 to 0. The first texel has step 1 of 3 and 2 of 7, 21 and 18 of 64 of the
  // way, the second has the last ones, the others 0.
  const Bc7Block block{0x10, 0xE0, 0x03, 0x00, 0xC0, 0x0F, 0x1C, 0x00, 0x00, 0x00, 0x3C, 0x00, 0x00, 0x00, 0x00, 0x00};
  const BlockTexels texels = texels_of(block);
  CHECK(texels[0] == std::array<std::uint8_t, 4>{84, 0, 0, 183});
  CHECK(texels[1] == std::array<std::uint8_t, 4>{255, 0, 0, 0});
  for (std::size_t i = 2; i < kBc7BlockTexels; ++i) CHECK(texels[i] == std::array<std::uint8_t, 4>{0, 0, 0, 255});
  // The first texel's step is the last: the ends change places, for its highest bit is not there.
  BlockTexels ramp{};
  for (std::size_t i = 0; i < kBc7BlockTexels; ++i) {
    const auto grey = static_cast<std::uint8_t>(255 - 17 * i);
    ramp[i] = {grey, grey, grey, 255};
  }
  CHECK(squared_error(through(ramp), ramp) <= 16 * 3 * 2 * 2);
}

TEST_CASE("one colour is kept to a level, and one alpha exactly, whatever the colours") {
  std::mt19937 random(1);
  const auto value = [&] { return static_cast<std::uint8_t>(random() % 256); };
  for (std::uint32_t alpha = 0; alpha < 256; ++alpha) {
    BlockTexels texels{};
    texels.fill({value(), value(), value(), static_cast<std::uint8_t>(alpha)});
    const BlockTexels seen = through(texels);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      REQUIRE(std::abs(seen[9][channel] - texels[9][channel]) <= 1);
    }
    for (auto& texel : texels) texel = {value(), value(), value(), static_cast<std::uint8_t>(alpha)};
    for (const auto& texel : through(texels)) REQUIRE(texel[3] == alpha);
  }
}

TEST_CASE("an alpha of 0 stays 0, no other becomes 0, and beside one colour none is off by more than a step of seven") {
  std::mt19937 random(3);
  for (int run = 0; run < 4000; ++run) {
    BlockTexels texels{};
    for (auto& texel : texels) {
      const auto kind = random() % 4;
      const auto alpha = kind == 0 ? 0 : kind == 1 ? 255 : kind == 2 ? 1 : random() % 256;
      texel = {90, 120, 30, static_cast<std::uint8_t>(alpha)};
    }
    const BlockTexels seen = through(texels);
    for (std::size_t i = 0; i < kBc7BlockTexels; ++i) {
      REQUIRE((seen[i][3] == 0) == (texels[i][3] == 0));
      REQUIRE(std::abs(seen[i][3] - texels[i][3]) <= 255 / 7);
    }
  }
}

TEST_CASE("a block of any colours shows what is to be shown and hides what is hidden") {
  std::mt19937 random(9);
  const auto value = [&] { return static_cast<std::uint8_t>(random() % 256); };
  for (int run = 0; run < 4000; ++run) {
    BlockTexels texels{};
    for (auto& texel : texels) {
      texel = {value(), value(), value(), static_cast<std::uint8_t>(random() % 3 == 0 ? 0 : value())};
    }
    const BlockTexels seen = through(texels);
    for (std::size_t i = 0; i < kBc7BlockTexels; ++i) REQUIRE((seen[i][3] == 0) == (texels[i][3] == 0));
  }
}

TEST_CASE("the ramp goes the way in which colours vary most, also if no channel alone varies as much") {
  // Red by rows; green and blue, which vary less each but more together, by columns.
  BlockTexels texels{};
  for (std::size_t i = 0; i < kBc7BlockTexels; ++i) {
    const auto grey = static_cast<std::uint8_t>(i % 2 == 0 ? 105 : 200);
    texels[i] = {static_cast<std::uint8_t>(i < 8 ? 100 : 200), grey, grey, 255};
  }
  CHECK(squared_error(through(texels), texels) <= 1.05 * 16 * 50 * 50);  // what is left is red, half its range
}

TEST_CASE("colours along any line are within half of its fifteen steps") {
  std::mt19937 random(5);
  for (int run = 0; run < 500; ++run) {
    std::array<int, 3> from{}, to{};
    for (int& value : from) value = static_cast<int>(random() % 256);
    for (int& value : to) value = static_cast<int>(random() % 256);
    BlockTexels texels{};
    for (std::size_t i = 0; i < kBc7BlockTexels; ++i) {
      const auto step = static_cast<int>(random() % 16);
      for (std::size_t channel = 0; channel < 3; ++channel) {
        texels[i][channel] = static_cast<std::uint8_t>(from[channel] + (to[channel] - from[channel]) * step / 15);
      }
      texels[i][3] = 255;
    }
    const BlockTexels seen = through(texels);
    for (std::size_t i = 0; i < kBc7BlockTexels; ++i) {
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const int half_a_step = std::abs(to[channel] - from[channel]) / 30;
        REQUIRE(std::abs(seen[i][channel] - texels[i][channel]) <= half_a_step + 4);  // and rounding of the ends
      }
    }
  }
}

TEST_CASE("where colour and alpha change apart, each keeps its own steps") {
  // Half is hidden; colours change across, alpha down.
  BlockTexels texels{};
  for (std::size_t i = 0; i < kBc7BlockTexels; ++i) {
    const auto grey = static_cast<std::uint8_t>(40 + 50 * (i % 4));
    texels[i] = {grey, grey, grey, static_cast<std::uint8_t>(i < 8 ? 0 : 255)};
  }
  CHECK(bc7_block(texels)[0] % 32 == 16);  // of mode 4
  const BlockTexels seen = through(texels);
  CHECK(squared_error(seen, texels) < 16 * 3 * 16);
  for (std::size_t i = 0; i < kBc7BlockTexels; ++i) CHECK(seen[i][3] == texels[i][3]);
}

TEST_CASE("the ends of a ramp are better than the extremes of what they stand for") {
  // Noise, where fifteen steps between the darkest and the brightest texel, chosen by hand, make this error.
  std::mt19937 random(7);
  double made = 0, extremes = 0;
  for (int run = 0; run < 200; ++run) {
    BlockTexels texels{};
    for (auto& texel : texels) {
      const auto grey = static_cast<std::uint8_t>(100 + random() % 100);
      const auto tint = [&] { return static_cast<std::uint8_t>(grey + random() % 24); };
      texel = {tint(), tint(), tint(), 255};
    }
    made += squared_error(through(texels), texels);
    const auto by_sum = [](const auto& a, const auto& b) { return a[0] + a[1] + a[2] < b[0] + b[1] + b[2]; };
    const auto [dark, bright] = std::minmax_element(texels.begin(), texels.end(), by_sum);
    for (const auto& texel : texels) {
      double least = 1e9;
      for (int step = 0; step < 16; ++step) {
        double error = 0;
        for (std::size_t channel = 0; channel < 3; ++channel) {
          const double shown = (*dark)[channel] + ((*bright)[channel] - (*dark)[channel]) * step / 15.0;
          error += std::pow(shown - texel[channel], 2);
        }
        least = std::min(least, error);
      }
      extremes += least;
    }
  }
  CHECK(made < 0.9 * extremes);
}

TEST_CASE("blocks of modes that are not written are refused") {
  Bc7Block block{};
  CHECK_THROWS_WITH(texels_of(block), "bc7 block: its mode is 8, must be 4 or 6");
  block[0] = 1 << 3;
  CHECK_THROWS_WITH(texels_of(block), "bc7 block: its mode is 3, must be 4 or 6");
  block[0] = 1 << 4 | 1 << 5;
  CHECK_THROWS_AS(texels_of(block), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
