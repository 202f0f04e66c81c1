// SPDX-License-Identifier: GPL-3.0-or-later
// Counts the texels that a picture's shader fetches, which is what a GPU's time goes to.
#include <algorithm>
#include <catch2/catch.hpp>
#include <iostream>
#include <optional>
#include <vector>

#include "blend/renderer.h"
#include "mesh/base/median.h"
#include "tests/support/gl_test_context.h"
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
// fetched when they were last set. A change that lowers the count lowers them too.
constexpr double kMedianLimit = 90;
constexpr double kTailLimit = 120;  // of 95 % of the pixels

TEST_CASE("the shader fetches no more texels a pixel than it did") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  renderer.load(room_snapshot(48, {}));
  const std::vector<double> counts = counts_of(renderer, {});
  REQUIRE(counts.size() > 50000);
  std::cout << "texels fetched a pixel: median " << percentile(counts, 0.5) << ", 95 % " << percentile(counts, 0.95)
            << '\n';
  CHECK(percentile(counts, 0.5) <= kMedianLimit);
  CHECK(percentile(counts, 0.95) <= kTailLimit);
}

TEST_CASE("linear sampling fetches fewer texels than cubic sampling, and one view fewer than three") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
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
