// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/image_levels.h"

#include <catch2/catch.hpp>
#include <stdexcept>

#include "tests/support/wall_scenes.h"

namespace lumatlas {
namespace {

StoredView two_by_two(const std::vector<std::uint8_t>& grey, const std::vector<std::uint8_t>& validity) {
  StoredView view;
  view.camera = forward_camera(2, 2);
  view.photograph = {2, 2, {}, {}};
  for (const std::uint8_t value : grey) view.photograph.rgb.insert(view.photograph.rgb.end(), 3, value);
  view.validity = validity;
  return view;
}

std::vector<std::uint8_t> coarse_texel(const std::vector<std::uint8_t>& grey,
                                       const std::vector<std::uint8_t>& validity) {
  return image_levels(two_by_two(grey, validity), {0, 0, 2, 2}, 2)[1].rgba;
}

using Texel = std::vector<std::uint8_t>;

TEST_CASE("a gutter of 2^n pixels allows n coarser levels") {
  CHECK(levels_of_gutter(0) == 1);
  CHECK(levels_of_gutter(1) == 1);
  CHECK(levels_of_gutter(2) == 2);
  CHECK(levels_of_gutter(4) == 3);
  CHECK(levels_of_gutter(8) == 4);
}

TEST_CASE("a coarser texel is the mean light of what may be shown") {
  CHECK(coarse_texel({7, 7, 7, 7}, {255, 255, 255, 255}) == Texel{7, 7, 7, 255});
  CHECK(coarse_texel({255, 0, 0, 255}, {255, 255, 255, 255}) == Texel{188, 188, 188, 255});  // half the light
  CHECK(coarse_texel({255, 0, 0, 0}, {255, 0, 0, 0}) == Texel{255, 255, 255, 64});           // the others do not bleed
  CHECK(coarse_texel({255, 0, 0, 255}, {0, 0, 0, 0}) == Texel{188, 188, 188, 0});
}

TEST_CASE("a part of a view has the levels of the whole, and its border goes on") {
  const auto surface = wall_and_panel();
  const StoredView view = traced_view(*surface, "a", forward_camera(30, 22), position_photograph(30, 22));
  const std::vector<ImageLevel> whole = image_levels(view, {-8, -8, 48, 40}, 4);
  const std::vector<ImageLevel> part = image_levels(view, {8, 8, 24, 16}, 4);
  for (std::uint32_t number = 0; number < 4; ++number) {
    const std::uint32_t shift = 16 >> number;
    REQUIRE(part[number].width == 24u >> number);
    for (std::uint32_t y = 0; y < part[number].height; ++y) {
      for (std::uint32_t x = 0; x < part[number].width; ++x) {
        for (std::uint32_t channel = 0; channel < 4; ++channel) {
          REQUIRE(part[number].rgba[4 * (y * part[number].width + x) + channel] ==
                  whole[number].rgba[4 * ((y + shift) * whole[number].width + x + shift) + channel]);
        }
      }
    }
  }
  for (std::uint32_t channel = 0; channel < 3; ++channel) CHECK(whole[0].rgba[channel] == view.photograph.rgb[channel]);
}

TEST_CASE("a part whose sides do not halve so often is refused") {
  const StoredView view = two_by_two({1, 2, 3, 4}, {255, 255, 255, 255});
  CHECK_THROWS_AS(image_levels(view, {0, 0, 6, 4}, 3), std::invalid_argument);
  CHECK_THROWS_AS(image_levels(view, {0, 0, 4, 4}, 0), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
