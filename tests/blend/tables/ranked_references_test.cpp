// SPDX-License-Identifier: GPL-3.0-or-later
// The order in which a zone's references are looked at, and that stopping early changes no picture.
#include "blend/tables/ranked_references.h"

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <random>
#include <vector>

#include "blend/geometric_weight.h"
#include "blend/renderer.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

// Numbers that every standard library draws alike.
class RankedDraws {
 public:
  double between(double least, double most) {
    return least + (most - least) * static_cast<double>(random_()) / 4294967295.0;
  }
  glm::dvec3 point(double size) { return {between(-size, size), between(-size, size), between(-size, size)}; }

 private:
  std::mt19937 random_{7};
};

BlendOptions printed_position() {
  BlendOptions options;
  options.position = BlendOptions::Position::printed;
  return options;
}

TEST_CASE("no view weighs more anywhere in a ball than its bound, wherever the cameras are") {
  RankedDraws draws;
  for (int round = 0; round < 20000; ++round) {
    BlendOptions options = round % 3 == 0 ? printed_position() : BlendOptions{};
    options.lambda = draws.between(0, 1);
    const Ball ball{draws.point(1), draws.between(0, round % 2 == 0 ? 0.2 : 2)};
    const glm::dvec3 novel = draws.point(3), stored = draws.point(3);
    const double bound = bound_of_weight(ball, novel, stored, options);
    CHECK(bound <= 1.001);
    for (int sample = 0; sample < 20; ++sample) {
      const glm::dvec3 step = draws.point(1);
      const glm::dvec3 world = ball.center + ball.radius * step / std::max(1.0, glm::length(step));
      CHECK(geometric_weight(world, novel, stored, options) <= bound);
    }
  }
}

TEST_CASE("the bound of a ball without extent is the weight at its centre") {
  RankedDraws draws;
  for (int round = 0; round < 100; ++round) {
    const glm::dvec3 world = draws.point(1), novel = draws.point(3), stored = draws.point(3);
    CHECK(bound_of_weight({world, 0}, novel, stored, {}) ==
          Approx(geometric_weight(world, novel, stored, {})).margin(2e-4));
  }
}

TEST_CASE("each zone's references stay the same ones, those of the largest bound first") {
  ZoneReferences lists;
  lists.references = {0u | 1u << 28, 1u | 1u << 28, 2u | 1u << 28, 3u | 1u << 28, 1u | 3u << 28};
  lists.ranges = {{0, 4}, {4, 5}};
  const std::vector<Ball> balls{{{0, 0, 5}, 0.5}, {{0, 0, -5}, 0.5}};  // the second is behind the camera
  const std::vector<std::optional<glm::dvec3>> centers{glm::dvec3(3, 0, 0), glm::dvec3(0.1, 0, 0), std::nullopt,
                                                       glm::dvec3(1, 0, 0)};
  std::vector<RankedReference> ranked = unranked(lists);
  rank_references(lists, balls, centered_camera(100, 100, 100), centers, {}, ranked);
  std::vector<std::uint32_t> slots;
  for (std::size_t i = 0; i < 4; ++i) slots.push_back(slot_of(ranked[i].x));
  CHECK(slots == std::vector<std::uint32_t>{1, 3, 0, 2});
  CHECK(std::bit_cast<float>(ranked[3].y) == 0);  // no view is in that slot
  CHECK(ranked[4] == RankedReference(1u | 3u << 28, std::bit_cast<std::uint32_t>(2.0F)));
}

// Counts the values that differ by more than rounding.
std::size_t ranked_differences(const std::vector<float>& a, const std::vector<float>& b) {
  REQUIRE(a.size() == b.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < a.size(); ++i) different += std::abs(a[i] - b[i]) > 1e-4F;
  return different;
}

TEST_CASE("a picture in which pixels stop early is that in which each pixel looks at all references") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot snapshot = room_snapshot(40, {});
  Renderer early, whole({.skip_losers = false});
  early.load(snapshot);
  whole.load(snapshot);
  std::vector<BlendOptions> variants(4);
  variants[1].border_width = 0.6;
  variants[2].views = 8;
  variants[3].views = 1;
  for (const BlendOptions& options : variants) {
    for (std::size_t number = 0; number < 16; number += 5) {
      Camera camera = room_camera(number).scaled_to(160, 120);
      camera.cam_from_world_translation += glm::dvec3(0.1, 0.05, -0.2);
      const LinearRendering a = early.render_linear(camera, options), b = whole.render_linear(camera, options);
      CHECK(a.state == b.state);
      CHECK(ranked_differences(a.rgb, b.rgb) == 0);
    }
  }
}

}  // namespace
}  // namespace lumatlas
