// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/report/error_picture.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "tests/support/oklab.h"

namespace lumatlas {
namespace {

using Color = std::array<std::uint8_t, 3>;

Photograph grey_row(const std::vector<std::uint8_t>& levels) {
  Photograph image;
  image.width = static_cast<std::uint32_t>(levels.size());
  image.height = 1;
  for (const std::uint8_t level : levels) {
    image.rgb.insert(image.rgb.end(), 3, level);
  }
  return image;
}

Color color_at(const Photograph& image, std::size_t pixel) {
  return {image.rgb[3 * pixel], image.rgb[3 * pixel + 1], image.rgb[3 * pixel + 2]};
}

TEST_CASE("perceived lightness grows in proportion to the error") {
  const double dark = oklab(error_color(0)).lightness;
  const double bright = oklab(error_color(kErrorFullScale)).lightness;
  CHECK(dark < 0.15);
  CHECK(bright > 0.95);
  for (double levels = 0; levels <= kErrorFullScale; levels += 0.5) {
    CAPTURE(levels);
    // Rounding to 8 bits moves dark colours by up to .01; clipping into sRGB would move them further.
    const double expected = dark + (bright - dark) * levels / kErrorFullScale;
    CHECK(oklab(error_color(levels)).lightness == Approx(expected).margin(0.015));
  }
}

TEST_CASE("errors beyond the full scale have the brightest colour") {
  CHECK(error_color(255) == error_color(kErrorFullScale));
}

TEST_CASE("an error picture has the colour of each pixel's difference, whatever its sign") {
  const Photograph picture = error_picture(grey_row({100, 100, 100, 0}), grey_row({100, 116, 84, 255}), {});
  CHECK(color_at(picture, 0) == error_color(0));
  CHECK(color_at(picture, 1) == error_color(16));
  CHECK(color_at(picture, 2) == error_color(16));
  CHECK(color_at(picture, 3) == error_color(kErrorFullScale));
}

TEST_CASE("the difference of a pixel is the root mean square over its channels") {
  Photograph rendering = grey_row({50});
  rendering.rgb[1] = 80;
  CHECK(color_at(error_picture(rendering, grey_row({50}), {}), 0) == error_color(30 / std::sqrt(3.0)));
}

TEST_CASE("pixels that do not count are marked, with a colour that no error has") {
  Photograph photograph = grey_row({10, 10, 10});
  photograph.valid = {255, 255, 0};
  const std::vector<std::uint8_t> mask = {0, 1, 1};
  const Photograph picture = error_picture(grey_row({0, 10, 0}), photograph, mask);
  CHECK(color_at(picture, 0) == kNotScoredColor);
  CHECK(color_at(picture, 1) == error_color(0));
  CHECK(color_at(picture, 2) == kNotScoredColor);
  for (double levels = 0; levels <= kErrorFullScale; levels += 0.1) {
    const Color color = error_color(levels);
    const int distance = std::abs(color[0] - kNotScoredColor[0]) + std::abs(color[1] - kNotScoredColor[1]) +
                         std::abs(color[2] - kNotScoredColor[2]);
    REQUIRE(distance > 60);
  }
}

TEST_CASE("an error picture of pictures of different sizes is refused") {
  CHECK_THROWS_WITH(error_picture(grey_row({1}), grey_row({1, 2}), {}),
                    "scores: the rendering is 1x1, must be 2x1 as the photograph");
}

}  // namespace
}  // namespace lumatlas
