// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/intrinsics.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <stdexcept>

#include "planner/planner.h"
#include "tests/support/small_scenes.h"

namespace lumatlas {
namespace {

constexpr std::size_t kViews = 26;

Camera true_camera(std::size_t number) {
  return room_camera(number).scaled_to(240, 180);
}

// 8-bit sRGB that varies smoothly over the room, with waves of about 20 to 100 cm in all directions.
glm::dvec3 paint(const glm::dvec3& at) {
  glm::dvec3 sum(0);
  for (int wave = 0; wave < 9; ++wave) {
    const double length = 6 + 2.5 * wave;
    const glm::dvec3 direction =
        glm::normalize(glm::dvec3(std::sin(1.3 * wave + 0.4), std::cos(2.1 * wave), std::sin(3.7 * wave + 1.1)));
    for (int channel = 0; channel < 3; ++channel) {
      sum[channel] += std::sin(length * glm::dot(direction, at) + 1.7 * wave * channel + wave);
    }
  }
  return 128.0 + 25.0 * sum;
}

Photograph photograph_of(const Camera& camera, const Visibility& visibility) {
  const VisibilityBuffer visible = visibility.trace(camera);
  Photograph photograph;
  photograph.width = camera.width;
  photograph.height = camera.height;
  for (std::uint32_t y = 0; y < camera.height; ++y) {
    for (std::uint32_t x = 0; x < camera.width; ++x) {
      const double depth = visible.depth[std::size_t{y} * camera.width + x];
      const glm::dvec3 color = paint(camera.center() + depth * camera.ray({x + 0.5, y + 0.5}));
      for (int channel = 0; channel < 3; ++channel) {
        photograph.rgb.push_back(static_cast<std::uint8_t>(std::lround(std::clamp(color[channel], 10.0, 245.0))));
      }
    }
  }
  return photograph;
}

PlannerOptions refining() {
  PlannerOptions options;
  options.coverage.ideal_distance = 2;
  options.min_view_gain = 0;
  options.refinement.trust.enabled = false;
  return options;
}

// Photographs of the painted room, taken with the true cameras; the planner is given others.
struct PaintedRoom {
  PaintedRoom(std::size_t views, const Intrinsics& error, std::size_t capacity = 0)
      : surface(room_surface()),
        visibility(make_ray_visibility(surface->mesh)),
        atlas(surface, static_cast<std::uint32_t>(std::max(views, capacity))),
        planner(atlas, *visibility, refining()) {
    for (std::size_t number = 0; number < views; ++number) {
      const Camera camera = true_camera(number);
      Camera given = camera;
      given.fx *= error.focal;
      given.fy *= error.focal;
      given.cx += error.principal.x;
      given.cy += error.principal.y;
      planner.offer("view " + std::to_string(number), given, photograph_of(camera, *visibility));
    }
    for (int step = 0; step < 3; ++step) planner.polish();
  }

  std::shared_ptr<const Surface> surface;
  std::unique_ptr<Visibility> visibility;
  Atlas atlas;
  Planner planner;
};

void check_same(const IntrinsicsEstimate& a, const IntrinsicsEstimate& b) {
  CHECK(a.correction.focal == b.correction.focal);
  CHECK(a.correction.principal == b.correction.principal);
  CHECK(a.correction.radial == b.correction.radial);
  CHECK(a.deviation.focal == b.deviation.focal);
  CHECK(a.residual_after == b.residual_after);
}

TEST_CASE("a focal length given 2 % too long is found within 0.2 %, believed, and the cameras take it") {
  PaintedRoom room(kViews, {1.02, {0, 0}, 0});
  const IntrinsicsEstimate estimate = room.planner.estimate_intrinsics();
  CAPTURE(estimate.correction.focal, estimate.deviation.focal, estimate.correction.principal.x,
          estimate.correction.principal.y, estimate.correction.radial, estimate.residual_before,
          estimate.residual_after, estimate.corner_px, estimate.views, estimate.points);
  CHECK(estimate.correction.focal == Approx(1 / 1.02).margin(0.002));
  CHECK(estimate.significant);
  CHECK(estimate.residual_after < estimate.residual_before);

  const IntrinsicsEstimate pinhole = room.planner.estimate_intrinsics({.radial = false});
  CHECK(std::abs(pinhole.correction.radial) < 1e-9);
  room.planner.set_cameras(pinhole);
  CHECK(room.atlas.view(0)->camera.fx == Approx(true_camera(0).fx).epsilon(0.002));
  const IntrinsicsEstimate again = room.planner.estimate_intrinsics();
  CHECK(again.correction.focal == Approx(1).margin(0.002));
  CHECK_FALSE(again.significant);
}

TEST_CASE("fewer points of a view find the same, less precisely") {
  const PaintedRoom room(kViews, {1.02, {0, 0}, 0});
  const IntrinsicsEstimate all = room.planner.estimate_intrinsics();
  const IntrinsicsEstimate some = room.planner.estimate_intrinsics({.most_points = 400});
  CAPTURE(all.points, some.points, all.deviation.focal, some.deviation.focal);
  CHECK(some.views == all.views);
  CHECK(some.points <= 400 * some.views);
  CHECK(some.points < all.points);
  CHECK(some.deviation.focal > all.deviation.focal);
  CHECK(some.correction.focal == Approx(1 / 1.02).margin(0.004));
  CHECK(some.significant);
  CHECK_THROWS_AS(room.planner.estimate_intrinsics({.most_points = 0}), std::invalid_argument);
}

TEST_CASE("right intrinsics are left alone") {
  const PaintedRoom room(kViews, {});
  const IntrinsicsEstimate estimate = room.planner.estimate_intrinsics();
  CAPTURE(estimate.correction.focal, estimate.deviation.focal, estimate.correction.radial, estimate.residual_before,
          estimate.residual_after, estimate.corner_px);
  CHECK(estimate.views > kViews / 2);
  CHECK_FALSE(estimate.significant);
  CHECK(estimate.correction.focal == Approx(1).margin(0.002));
}

TEST_CASE("a principal point given 3 px off is found within half a pixel and believed") {
  const PaintedRoom room(kViews, {1, {3, -3}, 0});
  const IntrinsicsEstimate estimate = room.planner.estimate_intrinsics();
  CAPTURE(estimate.correction.focal, estimate.deviation.principal.x, estimate.deviation.principal.y,
          estimate.residual_before, estimate.residual_after);
  CHECK(estimate.correction.principal.x == Approx(-3).margin(0.5));
  CHECK(estimate.correction.principal.y == Approx(3).margin(0.5));
  CHECK(estimate.significant);
}

TEST_CASE("one view alone says nothing about intrinsics, and an empty store neither") {
  const PaintedRoom one(1, {1.02, {0, 0}, 0});
  const IntrinsicsEstimate estimate = one.planner.estimate_intrinsics();
  CHECK_FALSE(estimate.significant);
  CHECK(estimate.views == 0);
  CHECK(estimate.correction.focal == 1);
  CHECK(estimate.cameras.size() == 1);

  const auto surface = room_surface();
  const auto visibility = make_ray_visibility(surface->mesh);
  Atlas atlas(surface, 3);
  const Planner empty(atlas, *visibility, refining());
  CHECK_FALSE(empty.estimate_intrinsics().significant);
}

TEST_CASE("what the atlas has room for makes no difference: as many unknowns, and the same estimate") {
  const PaintedRoom exact(6, {1.02, {0, 0}, 0});
  const IntrinsicsEstimate few = exact.planner.estimate_intrinsics();
  CHECK(few.unknowns == 4 + 7 * 6);
  for (const std::size_t capacity : {7u, 60u, 1280u}) {
    CAPTURE(capacity);
    const PaintedRoom roomy(6, {1.02, {0, 0}, 0}, capacity);
    const IntrinsicsEstimate estimate = roomy.planner.estimate_intrinsics();
    CHECK(estimate.unknowns == few.unknowns);
    CHECK(estimate.points == few.points);
    CHECK(estimate.cameras.size() == capacity);
    check_same(few, estimate);
  }
}

TEST_CASE("an estimate comes by its interruption point many times, and what is thrown there ends it") {
  struct Stop {};
  const PaintedRoom room(6, {1.02, {0, 0}, 0});
  std::atomic<int> calls = 0;
  IntrinsicsOptions options;
  options.interruption_point = [&] { ++calls; };
  check_same(room.planner.estimate_intrinsics(options), room.planner.estimate_intrinsics());
  // Each view's comparison and its part of the normal equations, in at least two rounds of two passes.
  const int all = calls;
  CHECK(all > 2 * 2 * 2 * 6);
  for (const int last : {0, 5, all / 3, all - 1}) {
    calls = 0;
    options.interruption_point = [&] {
      if (++calls > last) throw Stop();
    };
    CHECK_THROWS_AS(room.planner.estimate_intrinsics(options), Stop);
    CHECK(calls < last + 100);  // those of other threads that were on their way
  }
}

TEST_CASE("the estimate is the same on one thread as on many") {
  const PaintedRoom room(12, {1.02, {0, 0}, 0});
  const IntrinsicsEstimate many = room.planner.estimate_intrinsics();
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  check_same(many, room.planner.estimate_intrinsics());
}

}  // namespace
}  // namespace lumatlas
