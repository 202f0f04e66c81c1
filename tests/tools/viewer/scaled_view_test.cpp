// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/images/scaled_view.h"

#include <catch2/catch.hpp>
#include <stdexcept>

#include "atlas/images/image_levels.h"
#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/view_parts.h"

namespace lumatlas {
namespace {

StoredView view() {
  const Snapshot snapshot = room_snapshot(4, {});
  return *snapshot.views[2];
}

TEST_CASE("a factor of one changes nothing") {
  const StoredView stored = view();
  const ScaledView scaled = scaled_view(stored, 1);
  CHECK(scaled.photograph.rgb == stored.photograph->whole().rgb);
  CHECK(scaled.validity == stored.mask->validity);
  CHECK(scaled.rim == stored.mask->rim);
}

TEST_CASE("half the size is the next coarser level") {
  const StoredView stored = view();
  const ScaledView scaled = scaled_view(stored, 0.5);
  const ImageLevel level = image_levels(stored, {0, 0, stored.camera.width, stored.camera.height}, 2)[1];
  REQUIRE(scaled.width == level.width);
  REQUIRE(scaled.height == level.height);
  int most = 0;
  for (std::size_t i = 0; i < scaled.validity.size(); ++i) {
    most = std::max(most, std::abs(scaled.validity[i] - level.rgba[4 * i + 3]));
    for (std::size_t channel = 0; channel < 3; ++channel) {
      most = std::max(most, std::abs(scaled.photograph.rgb[3 * i + channel] - level.rgba[4 * i + channel]));
    }
  }
  CHECK(most <= 1);  // both round
}

TEST_CASE("other factors keep one colour, and a part of a pixel at the border") {
  StoredView stored = view();
  change_colors(stored, [](std::uint8_t) { return 77; });
  std::vector<std::uint8_t>& validity = own_mask(stored).validity.values();
  std::fill(validity.begin(), validity.end(), std::uint8_t{255});
  const ScaledView scaled = scaled_view(stored, 41.0 / 64);
  CHECK(scaled.width == 62);   // 61.5
  CHECK(scaled.height == 47);  // 46.125
  CHECK(scaled.photograph.rgb == std::vector<std::uint8_t>(3 * 62 * 47, 77));
  CHECK(scaled.validity == std::vector<std::uint8_t>(62 * 47, 255));
}

TEST_CASE("factors beyond (0, 1] are refused") {
  for (const double factor : {0.0, -1.0, 1.5}) CHECK_THROWS_AS(scaled_view(view(), factor), std::invalid_argument);
}

TEST_CASE("a small picture keeps its shape") {
  const Photograph small = small_picture(view(), 24);
  CHECK(small.width == 24);
  CHECK(small.height == 18);
  CHECK(small.rgb.size() == 3 * 24 * 18);
}

TEST_CASE("a small picture has no holes where tiles are missing") {
  StoredView stored = view();
  change_photograph(stored, [](Photograph& photograph) {
    std::fill(photograph.rgb.begin(), photograph.rgb.end(), std::uint8_t{90});
    for (std::uint32_t y = 16; y < 48; ++y) {  // two rows of tiles, without their last column
      for (std::uint32_t x = 0; x < 80; ++x) std::fill_n(&photograph.rgb[3 * (y * 96 + x)], 3, std::uint8_t{0});
    }
  });
  std::vector<std::uint8_t> there(6 * 5, 1);
  for (std::size_t tile = 6; tile < 18; ++tile) there[tile] = tile % 6 == 5 ? 1 : 0;
  const Photograph holes = small_picture(stored, 24);
  CHECK(std::count(holes.rgb.begin(), holes.rgb.end(), 0) == 3 * 20 * 8);
  const Photograph small = small_picture(stored, 24, there, 16);
  CHECK(small.rgb == std::vector<std::uint8_t>(3 * 24 * 18, 90));
  // A pixel without any neighbour to fill it from stays.
  CHECK(small_picture(stored, 24, std::vector<std::uint8_t>(30, 0), 16).rgb == holes.rgb);
}

}  // namespace
}  // namespace lumatlas
