// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/images/image_levels.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <random>
#include <stdexcept>

#include "atlas/images/lower_resolution.h"
#include "atlas/tiles/compressed_texels.h"
#include "tests/support/allocation_peak.h"
#include "tests/support/scenes/view_parts.h"
#include "tests/support/scenes/wall_scenes.h"
#include "tests/support/skip.h"

namespace lumatlas {
namespace {

StoredView two_by_two(const std::vector<std::uint8_t>& grey, const std::vector<std::uint8_t>& validity) {
  StoredView view;
  view.camera = forward_camera(2, 2);
  Photograph photograph{2, 2, {}, {}};
  for (const std::uint8_t value : grey) photograph.rgb.insert(photograph.rgb.end(), 3, value);
  view.photograph = std::make_shared<const StoredPhotograph>(std::move(photograph));
  own_mask(view).validity = validity;
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
  for (std::uint32_t channel = 0; channel < 3; ++channel)
    CHECK(whole[0].rgba[channel] == view.photograph->whole().rgb[channel]);
}

TEST_CASE("a part whose sides do not halve so often is refused") {
  const StoredView view = two_by_two({1, 2, 3, 4}, {255, 255, 255, 255});
  CHECK_THROWS_AS(image_levels(view, {0, 0, 6, 4}, 3), std::invalid_argument);
  CHECK_THROWS_AS(image_levels(view, {0, 0, 4, 4}, 0), std::invalid_argument);
}

ImageLevel through_blocks(const ImageLevel& level) {
  return decompressed(level.width, level.height, compressed(level));
}

TEST_CASE("a picture in blocks is that of its blocks, each in its place") {
  ImageLevel level{16, 8, {}};
  for (std::uint32_t y = 0; y < 8; ++y) {
    for (std::uint32_t x = 0; x < 16; ++x) {
      const auto grey = static_cast<std::uint8_t>(40 + 12 * (x / 4) + 80 * (y / 4) + x % 4 + y % 4);
      level.rgba.insert(level.rgba.end(), {grey, grey, grey, static_cast<std::uint8_t>(x < 12 ? 255 : 128)});
    }
  }
  const std::vector<std::uint8_t> blocks = compressed(level);
  CHECK(blocks.size() == 16 * 8);
  const ImageLevel seen = decompressed(16, 8, blocks);
  CHECK(seen.width == 16);
  CHECK(seen.height == 8);
  REQUIRE(seen.rgba.size() == level.rgba.size());
  for (std::size_t byte = 0; byte < level.rgba.size(); ++byte) {
    REQUIRE(std::abs(seen.rgba[byte] - level.rgba[byte]) <= (byte % 4 == 3 ? 0 : 1));
  }
  CHECK_THROWS_WITH(compressed(ImageLevel{6, 4, std::vector<std::uint8_t>(96)}),
                    "compressed texels: sides of 6x4 are no multiples of 4");
  CHECK_THROWS_AS(decompressed(8, 4, std::vector<std::uint8_t>(16)), std::invalid_argument);
}

TEST_CASE("every slot shows the same compressed texels of a view, whichever tile it holds") {
  const auto surface = wall_and_panel();
  const StoredView view = traced_view(*surface, "a", forward_camera(53, 38), position_photograph(53, 38));
  for (const TileOptions& layout : {TileOptions{8, 2, 0, TexelFormat::bc7}, TileOptions{24, 4, 0, TexelFormat::bc7},
                                    TileOptions{16, 8, 0, TexelFormat::bc7}}) {
    const std::uint32_t levels = levels_of(layout);
    const std::vector<ImageLevel> whole = shown_levels(view, layout, levels);
    const TileGrid grid(53, 38, layout.tile_px);
    for (std::uint32_t tile = 0; tile < grid.tiles(); ++tile) {
      const std::int64_t left = std::int64_t{tile % grid.columns} * layout.tile_px - layout.gutter_px;
      const std::int64_t top = std::int64_t{tile / grid.columns} * layout.tile_px - layout.gutter_px;
      const std::vector<ImageLevel> slot =
          image_levels(view, {left, top, layout.place_px(), layout.place_px()}, levels);
      for (std::uint32_t level = 0; level < levels; ++level) {
        const ImageLevel seen = through_blocks(slot[level]);
        std::size_t different = 0;
        for (std::int64_t y = 0; y < seen.height; ++y) {
          for (std::int64_t x = 0; x < seen.width; ++x) {
            const std::int64_t at_x = (left >> level) + x, at_y = (top >> level) + y;
            if (at_x < 0 || at_y < 0 || at_x >= whole[level].width || at_y >= whole[level].height) continue;
            for (std::int64_t channel = 0; channel < 4; ++channel) {
              different +=
                  seen.rgba[static_cast<std::size_t>(4 * (y * seen.width + x) + channel)] !=
                  whole[level].rgba[static_cast<std::size_t>(4 * (at_y * whole[level].width + at_x) + channel)];
            }
          }
        }
        CHECK(different == 0);
      }
    }
    CHECK_THROWS_AS(shown_levels(view, layout, levels + 1), std::invalid_argument);
  }
}

// Grey that rises by 2 a pixel to the right.
Photograph ramp(std::uint32_t width, std::uint32_t height) {
  Photograph photograph{width, height, {}, {}};
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      photograph.rgb.insert(photograph.rgb.end(), 3, static_cast<std::uint8_t>(60 + 2 * x));
    }
  }
  return photograph;
}

TEST_CASE("a photograph at lower resolution shows every place where it was") {
  const Photograph ramp_before = ramp(60, 8);
  for (const std::uint32_t width : {60u, 45u, 30u, 7u}) {
    const Photograph lower = at_lower_resolution(ramp_before, width, 5);
    REQUIRE(lower.rgb.size() == 3 * std::size_t{width} * 5);
    CHECK(lower.valid.empty());
    const double step = 60.0 / width;
    for (std::uint32_t x = 2; x + 2 < width; ++x) {
      const double expected = 60 + 2 * ((x + 0.5) * step - 0.5);
      CHECK(std::abs(lower.rgb[3 * x] - expected) < 2);  // filtered in linear light, and rounded
    }
  }
}

TEST_CASE("what the lens did not see has no part in a photograph at lower resolution") {
  Photograph photograph = ramp(40, 40);
  photograph.valid.assign(40 * 40, 255);
  for (std::uint32_t y = 0; y < 40; ++y) {
    for (std::uint32_t x = 0; x < 11; ++x) {
      photograph.valid[40 * y + x] = 0;
      std::fill_n(photograph.rgb.begin() + 3 * (40 * y + x), 3, std::uint8_t{255});
    }
  }
  const Photograph lower = at_lower_resolution(photograph, 20, 20);
  for (std::uint32_t x = 0; x < 20; ++x) {
    CHECK(lower.valid[x] == (x < 6 ? 0 : 255));  // pixel 5 covers one of both kinds
    if (x >= 6) CHECK(std::abs(lower.rgb[3 * x] - (60 + 2 * (2 * x + 0.5))) < 4);
  }
}

TEST_CASE("a mask at lower resolution is the mean of what each pixel covers") {
  const std::vector<std::uint8_t> mask{255, 255, 0, 0, 255, 0, 0, 0};
  CHECK(mask_at_lower_resolution(mask, {4, 2}, {2, 1}) == std::vector<std::uint8_t>{191, 0});
  CHECK(mask_at_lower_resolution({}, {4, 2}, {2, 1}).empty());
}

// Without bands.
std::vector<std::uint8_t> mean_mask(const std::vector<std::uint8_t>& mask, ImageSize from, ImageSize to) {
  std::vector<float> values(mask.begin(), mask.end()), lower(std::size_t{to.width} * to.height);
  const auto spec = [](ImageSize size) {
    return OIIO::ImageSpec(static_cast<int>(size.width), static_cast<int>(size.height), 1, OIIO::TypeDesc::FLOAT);
  };
  const OIIO::ImageBuf source(spec(from), values.data());
  OIIO::ImageBuf target(spec(to), lower.data());
  REQUIRE(OIIO::ImageBufAlgo::resize(target, source, "box"));
  std::vector<std::uint8_t> result;
  for (const float value : lower) result.push_back(static_cast<std::uint8_t>(std::lround(value)));
  return result;
}

TEST_CASE("a tall picture is made smaller in bands that leave no trace") {
  constexpr std::uint32_t kWidth = 2000, kHeight = 7001;  // 3 to 14 bands
  std::vector<std::uint8_t> mask(std::size_t{kWidth} * kHeight);
  std::mt19937 random(3);
  for (std::uint8_t& value : mask) value = static_cast<std::uint8_t>(random());
  for (const ImageSize to : {ImageSize{700, 2333}, ImageSize{1999, 7000}, ImageSize{3, 2}}) {
    CHECK(mask_at_lower_resolution(mask, {kWidth, kHeight}, to) == mean_mask(mask, {kWidth, kHeight}, to));
  }
  Photograph tall{kWidth, kHeight, {}, {}};
  for (std::uint32_t y = 0; y < kHeight; ++y) {
    tall.rgb.insert(tall.rgb.end(), 3 * std::size_t{kWidth}, static_cast<std::uint8_t>(y / 32));
  }
  constexpr std::uint32_t kLower = 3000;
  const Photograph lower = at_lower_resolution(tall, 500, kLower);
  std::size_t wrong = 0;
  for (std::uint32_t y = 3; y + 3 < kLower; ++y) {
    const double at = (y + 0.5) * kHeight / kLower;
    const int value = lower.rgb[3 * std::size_t{500} * y];
    wrong += value < static_cast<int>((at - 5) / 32) || value > static_cast<int>((at + 5) / 32);
  }
  CHECK(wrong == 0);
}

TEST_CASE("memory for a picture at lower resolution follows from its width and not from its height") {
  if (!allocations_are_counted()) return skip("a sanitizer has its own operator new");
  const auto bytes_beside_result = [](std::uint32_t height) {
    const Photograph photograph = ramp(1000, height);
    const AllocationPeak peak;
    const Photograph lower = at_lower_resolution(photograph, 500, height / 2);
    return static_cast<double>(peak.bytes() - lower.rgb.size());
  };
  CHECK(bytes_beside_result(16000) < 1.1 * bytes_beside_result(4000));
  CHECK(bytes_beside_result(16000) < 40e6);
}

TEST_CASE("a resolution that is none, or above the photograph's, is refused") {
  const Photograph photograph = ramp(8, 4);
  CHECK_THROWS_AS(at_lower_resolution(photograph, 0, 4), std::invalid_argument);
  CHECK_THROWS_AS(at_lower_resolution(photograph, 8, 5), std::invalid_argument);
  Photograph cut_off = photograph;
  cut_off.rgb.pop_back();
  CHECK_THROWS_AS(at_lower_resolution(cut_off, 4, 2), std::invalid_argument);
  const std::vector<std::uint8_t> mask(31, 255);
  CHECK_THROWS_WITH(mask_at_lower_resolution(mask, {8, 4}, {4, 2}), Catch::Contains("has 31 values"));
}

}  // namespace
}  // namespace lumatlas
