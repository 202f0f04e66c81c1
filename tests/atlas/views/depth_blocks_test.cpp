// SPDX-License-Identifier: GPL-3.0-or-later
// The laws of depth in blocks, on stored views of which only depth, validity and rims matter.
#include "atlas/views/depth_blocks.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <vector>
#include "tests/support/scenes/view_parts.h"

namespace lumatlas {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();

// All is valid and no pixel is at a rim.
StoredView view_of(std::uint32_t width, std::uint32_t height, const std::function<float(double, double)>& depth_at) {
  StoredView view;
  view.camera.width = width;
  view.camera.height = height;
  ViewMask& mask = own_mask(view);
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) mask.depth.values().push_back(depth_at(x, y));
  }
  mask.validity.values().assign(mask.depth.size(), 255);
  mask.rim.values().assign(mask.depth.size(), 0);
  return view;
}

// The largest shares of its depth by which a pixel is shown too near, and too far.
struct Errors {
  double near = 0, far = 0;
};

Errors errors_of(const StoredView& view) {
  Errors errors;
  const std::vector<BlockPixel> shown = shown_depths(view);
  REQUIRE(shown.size() == view.mask->depth.size());
  for (std::size_t pixel = 0; pixel < shown.size(); ++pixel) {
    if (view.mask->validity[pixel] == 0) continue;
    const double ratio = shown[pixel].reciprocal * static_cast<double>(view.mask->depth[pixel]);
    errors.near = std::max(errors.near, ratio - 1);
    errors.far = std::max(errors.far, 1 - ratio);
  }
  return errors;
}

// Returns the depths of a plane that is seen at a slant: its reciprocal depth is linear in the image.
float aslant(double nearest, double x, double y) {
  return static_cast<float>(1 / (1 / nearest - 0.0021 * x - 0.0013 * y));
}

TEST_CASE("a plane is shown as it is, at any scale, and never found behind itself") {
  for (const double size : {1e-4, 1.0, 1e5}) {
    const Errors errors =
        errors_of(view_of(37, 29, [&](double x, double y) { return static_cast<float>(size) * aslant(2, x, y); }));
    CHECK(errors.near <= 0);
    CHECK(errors.far < 0.001);  // half precision is good for 0.0005
  }
}

TEST_CASE("of two surfaces in a block each pixel shows its own") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int run = 0; run < 50; ++run) {
    const double across = number(random), down = number(random), edge = 10 * number(random);
    const StoredView view = view_of(40, 40, [&](double x, double y) {
      const bool behind = across * (x - 20) + down * (y - 20) > edge;
      return behind ? 2 * aslant(2, x, y) : aslant(2, x, y);
    });
    const Errors errors = errors_of(view);
    REQUIRE(errors.near <= 0);
    REQUIRE(errors.far < 0.005);
  }
}

TEST_CASE("what is not valid takes nothing from what is, and where nothing is, nothing hides") {
  StoredView view = view_of(24, 24, [](double x, double y) { return aslant(x < 12 ? 2 : x < 16 ? 3 : 9, x, y); });
  for (std::size_t pixel = 0; pixel < view.mask->depth.size(); ++pixel) {
    if (pixel % 24 >= 12 && pixel % 24 < 16)
      own_mask(view).validity.values()[pixel] = 0;  // three surfaces in a block, two of them valid
  }
  own_mask(view).depth.values()[5] = kNothing;
  own_mask(view).validity.values()[5] = 0;
  CHECK(errors_of(view).near <= 0);
  CHECK(errors_of(view).far < 0.02);
  const StoredView empty = view_of(9, 3, [](double, double) { return kNothing; });
  for (const BlockPixel& pixel : shown_depths(empty)) {
    CHECK(pixel.reciprocal == 0);
    CHECK_FALSE(pixel.at_rim);
  }
}

TEST_CASE("a block is whole unless a pixel of it, or next to it, is not wholly valid") {
  for (const bool step : {false, true}) {
    const StoredView view = view_of(32, 30, [&](double x, double y) { return aslant(step && x > y ? 4 : 2, x, y); });
    const float scale = depth_scale(view);
    for (std::uint32_t row = 0; row < 30; ++row) {
      for (std::uint32_t column = 0; column < 32; ++column) {
        StoredView masked = view;
        own_mask(masked).validity.values()[row * 32 + column] = 254;
        for (std::uint32_t y = 0; y < 30; y += kDepthBlockSide) {
          for (std::uint32_t x = 0; x < 32; x += kDepthBlockSide) {
            const bool near =
                column + 1 >= x && column <= x + kDepthBlockSide && row + 1 >= y && row <= y + kDepthBlockSide;
            const DepthBlock block = depth_block(masked, x, y, scale);
            REQUIRE(((block[0] & kWholeBit) == 0) == near);
            REQUIRE((block[0] & ~kWholeBit) == (depth_block(view, x, y, scale)[0] & ~kWholeBit));
          }
        }
      }
    }
  }
}

TEST_CASE("a rough surface's depths are shown to its roughness") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> rough(-0.01, 0.01);
  const Errors errors = errors_of(
      view_of(64, 64, [&](double x, double y) { return static_cast<float>(1 + rough(random)) * aslant(2, x, y); }));
  CHECK(errors.near <= 0);
  CHECK(errors.far < 0.025);  // from one side of the roughness to the other
}

TEST_CASE("rims are those of the view on a plane, and none is lost where two surfaces are") {
  std::mt19937 random(5);
  for (const bool step : {false, true}) {
    StoredView view = view_of(32, 32, [&](double x, double y) { return aslant(step && x > y ? 4 : 2, x, y); });
    for (std::uint8_t& rim : own_mask(view).rim.values()) rim = random() % 4 == 0 ? 1 : 0;
    const std::vector<BlockPixel> shown = shown_depths(view);
    std::size_t lost = 0, more = 0;
    for (std::size_t pixel = 0; pixel < shown.size(); ++pixel) {
      lost += view.mask->at_rim(pixel) && !shown[pixel].at_rim ? 1 : 0;
      more += !view.mask->at_rim(pixel) && shown[pixel].at_rim ? 1 : 0;
    }
    CHECK(lost == 0);
    CHECK((more == 0) == !step);
  }
}

}  // namespace
}  // namespace lumatlas
