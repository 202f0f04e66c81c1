// SPDX-License-Identifier: GPL-3.0-or-later
// Counts the texels that a picture's shader fetches, which is what a GPU's time goes to.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <iostream>
#include <optional>
#include <vector>

#include "blend/renderer.h"
#include "blend/sampling/cubic_kernel.h"
#include "blend/sampling/supersampling.h"
#include "mesh/base/median.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/rendering_difference.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

// The same room from a camera between those of two stored views, and larger.
Camera camera_after(std::size_t number) {
  Camera camera = room_camera(number).scaled_to(192, 144);
  const glm::dvec3 center = (room_camera(number).center() + room_camera(number + 1).center()) / 2.0;
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * center);
  return camera;
}

std::vector<double> counts_of(Renderer& renderer, const BlendOptions& options) {
  std::vector<double> counts;
  for (std::size_t number = 0; number < 12; number += 3) {
    for (const std::uint32_t count : renderer.count_fetches(camera_after(number), options)) {
      if (count > 0) counts.push_back(count);
    }
  }
  return counts;
}

// A change that makes the shader fetch more lowers the frame rate of every GPU: these limits are a little above what it
// fetched when they were last set. A change that lowers the count lowers them too. Texel by texel, the validity between
// texels counts as the four that are fetched; in pairs as one.
constexpr double kMedianLimit = 90;
constexpr double kTailLimit = 119;  // of 95 % of the pixels
// The same where pairs of texels are fetched as one.
constexpr double kMedianLimitOfPairs = 66;
constexpr double kTailLimitOfPairs = 85;

TEST_CASE("the shader fetches no more texels a pixel than it did") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer({.filtered_taps = false});
  renderer.load(room_snapshot(48, {}));
  const std::vector<double> counts = counts_of(renderer, {});
  REQUIRE(counts.size() > 50000);
  std::cout << "texels fetched a pixel: median " << percentile(counts, 0.5) << ", 95 % " << percentile(counts, 0.95)
            << '\n';
  CHECK(percentile(counts, 0.5) <= kMedianLimit);
  CHECK(percentile(counts, 0.95) <= kTailLimit);
}

// Mesa's software filters at one level for 2 x 2 pixels, and wrongly where these go through a loop for different times.
// So pairs are compared where each pixel shows one view at one level; elsewhere few pixels differ.
TEST_CASE("in pairs the shader fetches a quarter less, and draws the same picture") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  for (const std::uint32_t gutter : {1u, 2u, 4u, 8u}) {
    CAPTURE(gutter);
    const Snapshot snapshot = room_snapshot(14, {}, {32, gutter, 0});
    Renderer pairs({.filtered_taps = true}), texels({.filtered_taps = false});
    pairs.load(snapshot);
    texels.load(snapshot);
    BlendOptions options;
    if (gutter == 1) options.sampling = BlendOptions::Sampling::linear;  // such tiles have no room for cubic
    BlendOptions one = at_middle(options);
    one.views = 1;
    one.border_width = 0;
    one.prefilter = false;
    for (const std::size_t number : {3u, 5u, 8u}) {
      const Camera camera = camera_after(number);
      CHECK(share_different(pairs.render(camera, one), texels.render(camera, one), 1) == 0);
      CHECK(share_different(pairs.render(camera, options), texels.render(camera, options), 2) <= 0.03);
    }
  }
  Renderer pairs({.filtered_taps = true});
  pairs.load(room_snapshot(48, {}));
  const std::vector<double> counts = counts_of(pairs, {});
  std::cout << "fetches a pixel in pairs: median " << percentile(counts, 0.5) << ", 95 % " << percentile(counts, 0.95)
            << '\n';
  CHECK(percentile(counts, 0.5) <= kMedianLimitOfPairs);
  CHECK(percentile(counts, 0.95) <= kTailLimitOfPairs);
}

// GPUs weigh the two texels of a pair in steps of 1/256.
TEST_CASE("the steps of a GPU's filter change colours by little, and least where photographs are smooth") {
  constexpr double kSteps = 256;
  const auto weighed = [&](const std::array<double, 4>& shares, const std::array<double, 4>& values, bool in_steps) {
    const double both = shares[1] + shares[2];
    const double second = in_steps ? std::round(kSteps * shares[2] / both) / kSteps : shares[2] / both;
    return shares[0] * values[0] + both * (values[1] + second * (values[2] - values[1])) + shares[3] * values[3];
  };
  double most = 0;  // share of the difference of the two texels
  for (const double width : {1.0, 1.5, 2.2}) {
    for (int place = 0; place < 1000; ++place) {
      const std::array<double, 4> shares = cubic_shares(place / 1000.0, width);
      CHECK(shares[1] + shares[2] > 0.6);  // so that a pair has a weight of one sign
      const std::array<double, 4> step{0, 0, 1, 1};
      most = std::max(most, std::abs(weighed(shares, step, true) - weighed(shares, step, false)));
    }
  }
  CHECK(most <= kFilterStep);
  CHECK(most > 0.8 * kFilterStep);
}

TEST_CASE("linear sampling fetches fewer texels than cubic sampling, and one view fewer than three") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer({.filtered_taps = false});
  renderer.load(room_snapshot(48, {}));
  BlendOptions linear;
  linear.sampling = BlendOptions::Sampling::linear;
  BlendOptions one_view;
  one_view.views = 1;
  const double all = percentile(counts_of(renderer, {}), 0.5);
  CHECK(percentile(counts_of(renderer, linear), 0.5) < all);
  CHECK(percentile(counts_of(renderer, one_view), 0.5) < all);
}

}  // namespace
}  // namespace lumatlas
