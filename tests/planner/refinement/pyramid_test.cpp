// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/pyramid.h"

#include <tbb/global_control.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <random>

#include "atlas/images/srgb.h"

namespace lumatlas {
namespace {

Photograph random_photograph(std::uint32_t width, std::uint32_t height, std::uint32_t seed = 1) {
  std::mt19937 random(seed);
  Photograph photograph{width, height, {}, {}};
  for (std::size_t i = 0; i < 3 * std::size_t{width} * height; ++i) {
    photograph.rgb.push_back(static_cast<std::uint8_t>(random() % 256));
  }
  return photograph;
}

Photograph chequerboard(std::uint32_t side) {
  Photograph photograph{side, side, {}, {}};
  for (std::uint32_t y = 0; y < side; ++y) {
    for (std::uint32_t x = 0; x < side; ++x) photograph.rgb.insert(photograph.rgb.end(), 3, (x + y) % 2 ? 255 : 0);
  }
  return photograph;
}

glm::dvec3 linear_pixel(const PhotographSpan& photograph, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t* rgb = &photograph.rgb[3 * (std::size_t{y} * photograph.width + x)];
  return {linear_from_srgb8()[rgb[0]], linear_from_srgb8()[rgb[1]], linear_from_srgb8()[rgb[2]]};
}

double largest(const glm::dvec3& v) {
  return std::max({std::abs(v.r), std::abs(v.g), std::abs(v.b)});
}

TEST_CASE("a chequerboard of black and white halves to half the light, not to half the sRGB value") {
  const Photograph board = chequerboard(64);
  const Pyramid pyramid(board, 8);
  REQUIRE(pyramid.levels() == 4);
  for (std::uint32_t level = 1; level < pyramid.levels(); ++level) {
    // sRGB of 0.5 is 187.5: 188.
    for (const std::uint8_t value : pyramid.level(level).rgb) REQUIRE(static_cast<int>(value) == 188);
  }
}

TEST_CASE("each level is the mean light of 2x2 pixels of the one before, to the nearest sRGB value") {
  const Photograph photograph = random_photograph(46, 34);
  const Pyramid pyramid(photograph, 10);
  REQUIRE(pyramid.levels() == 3);
  for (std::uint32_t index = 1; index < pyramid.levels(); ++index) {
    const PhotographSpan& full = pyramid.level(index - 1);
    const PhotographSpan& half = pyramid.level(index);
    for (std::uint32_t y = 0; y < half.height; ++y) {
      for (std::uint32_t x = 0; x < half.width; ++x) {
        const glm::dvec3 mean =
            0.25 * (linear_pixel(full, 2 * x, 2 * y) + linear_pixel(full, 2 * x + 1, 2 * y) +
                    linear_pixel(full, 2 * x, 2 * y + 1) + linear_pixel(full, 2 * x + 1, 2 * y + 1));
        for (int channel = 0; channel < 3; ++channel) {
          const int stored = half.rgb[3 * (std::size_t{y} * half.width + x) + static_cast<std::size_t>(channel)];
          // A table in place of the power function: off by one where the value lies between two.
          REQUIRE(std::abs(stored - 255 * srgb_from_linear(mean[channel])) < 0.6);
        }
      }
    }
  }
}

TEST_CASE("every 8-bit value survives halving of a flat picture") {
  for (int value = 0; value < 256; ++value) {
    const Photograph flat{8, 8, std::vector<std::uint8_t>(3 * 64, static_cast<std::uint8_t>(value)), {}};
    const Pyramid pyramid(flat, 4);
    REQUIRE(pyramid.levels() == 2);
    for (const std::uint8_t halved : pyramid.level(1).rgb) REQUIRE(static_cast<int>(halved) == value);
  }
}

TEST_CASE("what lies outside of the lens's image has no part in coarser levels") {
  constexpr int kGrey = 120;
  Photograph flat{64, 48, {}, {}};
  std::mt19937 random(4);
  for (std::uint32_t y = 0; y < flat.height; ++y) {
    for (std::uint32_t x = 0; x < flat.width; ++x) {
      const bool valid = x >= 19 && random() % 4 != 0;
      flat.valid.push_back(valid ? 255 : 0);
      flat.rgb.insert(flat.rgb.end(), 3, static_cast<std::uint8_t>(valid ? kGrey : 0));
    }
  }
  const Pyramid pyramid(flat, 8);
  REQUIRE(pyramid.levels() == 4);
  const glm::dvec3 expected(linear_from_srgb8()[kGrey]);
  std::uniform_real_distribution<double> within(0, 1);
  for (std::uint32_t y = 0; y < flat.height; ++y) {
    for (std::uint32_t x = 0; x < flat.width; ++x) {
      const glm::dvec2 at(x + within(random), y + within(random));
      // Everywhere else black is interpolated.
      REQUIRE(pyramid.is_valid(at) == (largest(pyramid.color(0, at) - expected) < 1e-9));
      if (flat.valid[std::size_t{y} * flat.width + x] == 0) continue;
      for (std::uint32_t level = 1; level < pyramid.levels(); ++level) {
        CAPTURE(level, at.x, at.y);
        const ColorSample sample = pyramid.sample(level, at);
        REQUIRE(largest(sample.color - expected) < 1e-6);
        REQUIRE(largest(sample.d_x) + largest(sample.d_y) < 1e-6);
      }
    }
  }
  const PhotographSpan& coarsest = pyramid.level(3);
  CHECK(coarsest.valid[0] == 0);
  CHECK(coarsest.rgb[0] == 0);
  CHECK(coarsest.valid[2] == 255);
}

TEST_CASE("levels go on while the longer side stays as long as asked, and odd last rows and columns are left out") {
  const Photograph odd = random_photograph(101, 67);
  const Pyramid pyramid(odd, 12);
  REQUIRE(pyramid.levels() == 4);
  CHECK(pyramid.level(1).width == 50);
  CHECK(pyramid.level(1).height == 33);
  CHECK(pyramid.level(2).width == 25);
  CHECK(pyramid.level(2).height == 16);
  CHECK(pyramid.level(3).width == 12);
  CHECK(pyramid.level(3).height == 8);
  CHECK(Pyramid(odd, 13).levels() == 3);
  CHECK(Pyramid(odd, 101).levels() == 1);
  CHECK(Pyramid(odd, 1000).levels() == 1);
}

TEST_CASE("narrow and tiny photographs have pyramids") {
  const Photograph strip = random_photograph(300, 1);
  CHECK(Pyramid(strip, 10).levels() == 1);
  const Photograph band = random_photograph(300, 7);
  const Pyramid banded(band, 10);
  REQUIRE(banded.levels() == 2);
  CHECK(banded.level(1).height == 3);
  const Photograph dot = random_photograph(1, 1);
  const Pyramid single(dot, 1);
  REQUIRE(single.levels() == 1);
  const ColorSample sample = single.sample(0, {0.5, 0.5});
  CHECK(sample.color == linear_pixel(dot, 0, 0));
  CHECK(sample.d_x == glm::dvec3(0));
  CHECK(sample.d_y == glm::dvec3(0));
}

TEST_CASE("at pixel centres the colour is the pixel's, at every level") {
  const Photograph photograph = random_photograph(32, 24);
  const Pyramid pyramid(photograph, 8);
  REQUIRE(pyramid.levels() == 3);
  for (std::uint32_t level = 0; level < pyramid.levels(); ++level) {
    const PhotographSpan& image = pyramid.level(level);
    const double size = std::exp2(level);  // of a pixel of this level in pixels of the full resolution
    for (std::uint32_t y = 0; y < image.height; ++y) {
      for (std::uint32_t x = 0; x < image.width; ++x) {
        const glm::dvec2 centre(size * (x + 0.5), size * (y + 0.5));
        REQUIRE(pyramid.color(level, centre) == linear_pixel(image, x, y));
        REQUIRE(pyramid.sample(level, centre).color == linear_pixel(image, x, y));
      }
    }
  }
}

TEST_CASE("half way between four pixels the colour is their mean, and outside it is held at the border") {
  const Photograph photograph = random_photograph(9, 9);
  const Pyramid pyramid(photograph);
  const glm::dvec3 mean = 0.25 * (linear_pixel(photograph, 3, 4) + linear_pixel(photograph, 4, 4) +
                                  linear_pixel(photograph, 3, 5) + linear_pixel(photograph, 4, 5));
  CHECK(largest(pyramid.color(0, {4, 5}) - mean) < 1e-12);
  CHECK(pyramid.color(0, {-7, -3}) == linear_pixel(photograph, 0, 0));
  CHECK(pyramid.color(0, {0.2, 0.4}) == linear_pixel(photograph, 0, 0));
  CHECK(pyramid.color(0, {12, 40}) == linear_pixel(photograph, 8, 8));
  CHECK(pyramid.color(0, {-1, 4.5}) == linear_pixel(photograph, 0, 4));
}

TEST_CASE("the derivatives are those of the colour, per pixel of the full resolution, at every level") {
  const Photograph photograph = random_photograph(40, 32);
  const Pyramid pyramid(photograph, 10);
  REQUIRE(pyramid.levels() == 3);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> inside(0.01, 0.99);
  for (std::uint32_t level = 0; level < pyramid.levels(); ++level) {
    const double size = std::exp2(level);
    for (int repeat = 0; repeat < 500; ++repeat) {
      // Between four pixel centres the colour is bilinear, and central differences are exact apart from rounding.
      const double column = static_cast<double>(random() % (pyramid.level(level).width - 1));
      const double row = static_cast<double>(random() % (pyramid.level(level).height - 1));
      const glm::dvec2 at = size * glm::dvec2(column + 0.5 + inside(random), row + 0.5 + inside(random));
      const ColorSample sample = pyramid.sample(level, at);
      const double h = 1e-4;
      const glm::dvec3 d_x =
          (pyramid.color(level, {at.x + h, at.y}) - pyramid.color(level, {at.x - h, at.y})) / (2 * h);
      const glm::dvec3 d_y =
          (pyramid.color(level, {at.x, at.y + h}) - pyramid.color(level, {at.x, at.y - h})) / (2 * h);
      REQUIRE(sample.color == pyramid.color(level, at));
      REQUIRE(largest(sample.d_x - d_x) < 1e-9);
      REQUIRE(largest(sample.d_y - d_y) < 1e-9);
    }
  }
}

TEST_CASE("where the colour is held, in the half pixel at each border and outside, the derivative across it is 0") {
  const Photograph photograph = random_photograph(40, 32);
  const Pyramid pyramid(photograph, 10);
  REQUIRE(pyramid.levels() == 3);
  for (std::uint32_t level = 0; level < pyramid.levels(); ++level) {
    const double size = std::exp2(level);
    const double right = pyramid.level(level).width - 0.5, bottom = pyramid.level(level).height - 0.5;
    const double inside_x = 7.3, inside_y = 5.6;
    for (const double out : {-30.0, -0.01, 0.0, 0.2, 0.49}) {
      CAPTURE(level, out);
      for (const double x : {out, right + 0.5 - out}) {
        const ColorSample sample = pyramid.sample(level, size * glm::dvec2(x, inside_y));
        CHECK(sample.d_x == glm::dvec3(0));
        CHECK(sample.d_y != glm::dvec3(0));
      }
      for (const double y : {out, bottom + 0.5 - out}) {
        const ColorSample sample = pyramid.sample(level, size * glm::dvec2(inside_x, y));
        CHECK(sample.d_y == glm::dvec3(0));
        CHECK(sample.d_x != glm::dvec3(0));
      }
    }
  }
}

TEST_CASE("a pyramid that is told of a copy reads the copy, and keeps its other levels") {
  const Photograph first = random_photograph(64, 64, 1);
  const Photograph second = random_photograph(64, 64, 2);
  Pyramid pyramid(first, 16);
  const PhotographSpan half = pyramid.level(1);
  pyramid.refer_to(second);
  CHECK(pyramid.level(0).rgb.data() == second.rgb.data());
  CHECK(pyramid.level(1).rgb.data() == half.rgb.data());
  CHECK(pyramid.color(0, {0.5, 0.5}) == linear_pixel(second, 0, 0));
}

TEST_CASE("a pyramid has the same bytes on one thread as on four") {
  const Photograph photograph = random_photograph(333, 257);
  const auto bytes = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const Pyramid pyramid(photograph, 20);
    std::vector<std::vector<std::uint8_t>> levels;
    for (std::uint32_t level = 0; level < pyramid.levels(); ++level) {
      const std::span<const std::uint8_t> rgb = pyramid.level(level).rgb;
      levels.emplace_back(rgb.begin(), rgb.end());
    }
    return levels;
  };
  CHECK(bytes(1) == bytes(4));
}

}  // namespace
}  // namespace lumatlas
