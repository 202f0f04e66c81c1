// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/stereo/luma_image.h"

#include <catch2/catch.hpp>
#include <stdexcept>

#include "tests/support/scenes/relief_scenes.h"

namespace lumatlas {
namespace {

Photograph grey(std::uint32_t width, std::uint32_t height) {
  Photograph photograph{width, height, {}, {}};
  for (std::uint32_t i = 0; i < width * height; ++i) {
    photograph.rgb.insert(photograph.rgb.end(), 3, static_cast<std::uint8_t>(i % 251));
  }
  return photograph;
}

Camera camera_of(std::uint32_t width, std::uint32_t height) {
  return camera_on_arc(0).scaled_to(width, height);
}

TEST_CASE("a quad holds its pixel and those to the right and below, of which the last are repeated") {
  const LumaPyramid pyramid = luma_pyramid(grey(3, 2), camera_of(3, 2), 8, 8);
  REQUIRE(pyramid.size() == 1);
  CHECK(pyramid[0].quads ==
        std::vector<std::uint32_t>{0x04030100, 0x05040201, 0x05050202, 0x04030403, 0x05040504, 0x05050505});
  CHECK(pyramid[0].luma(4) == 4);
}

TEST_CASE("levels halve down to the shortest size, and cameras follow them") {
  const LumaPyramid pyramid = luma_pyramid(grey(240, 180), camera_on_arc(0), 120, 30);
  REQUIRE(pyramid.size() == 3);
  CHECK(pyramid[0].camera.width == 120);
  CHECK(pyramid[2].camera.width == 30);
  CHECK(pyramid[2].camera.height == 23);
  CHECK(pyramid[2].camera.fx == Approx(camera_on_arc(0).fx / 8));
  CHECK(pyramid[2].quads.size() == 30 * 23);
}

TEST_CASE("a pixel of a smaller level is valid where all that it covers is") {
  Photograph photograph = grey(8, 8);
  photograph.valid.assign(64, 255);
  photograph.valid[0] = 0;
  const LumaPyramid pyramid = luma_pyramid(photograph, camera_of(8, 8), 8, 4);
  REQUIRE(pyramid.size() == 2);
  CHECK_FALSE(pyramid[1].is_valid(0));
  CHECK(pyramid[1].is_valid(15));
}

TEST_CASE("a photograph of another size than its camera's, and sizes without sense, are refused") {
  CHECK_THROWS_AS(luma_pyramid(grey(3, 2), camera_of(2, 3), 8, 8), std::invalid_argument);
  CHECK_THROWS_AS(luma_pyramid(grey(3, 2), camera_of(3, 2), 8, 0), std::invalid_argument);
  CHECK_THROWS_AS(luma_pyramid(grey(3, 2), camera_of(3, 2), 8, 9), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
