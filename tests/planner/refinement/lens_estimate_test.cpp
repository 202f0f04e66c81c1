// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/lens_estimate.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <stdexcept>

#include "planner/planner.h"
#include "tests/planner/refinement/painted_room.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

constexpr std::size_t kRoomViews = 13;

Camera true_camera(std::size_t number) {
  return painted_camera(number);
}

// The inverse of uncorrected(), by fixed-point iteration.
glm::dvec2 corrected(const LensCorrection& correction, const Camera& camera, const glm::dvec2& image) {
  glm::dvec2 guess = image;
  for (int i = 0; i < 10; ++i) guess -= uncorrected(correction, camera, guess) - image;
  return guess;
}

// What a lens with an error takes of the room, seen through a correction: each pixel shows the true camera's ray
// through corrected(error, uncorrected(correction, pixel)).
Photograph photograph_of(const Camera& camera, const Visibility& visibility, const LensCorrection& error,
                         const LensCorrection& correction = {}) {
  return painted_photograph(camera, visibility, [&](const glm::dvec2& pixel) {
    return corrected(error, camera, uncorrected(correction, camera, pixel));
  });
}

// Photographs of the painted room by lenses with an error, which the planner does not know of.
struct PaintedRoom {
  PaintedRoom(std::size_t views, const LensCorrection& error, std::size_t capacity = 0)
      : surface(room_surface()),
        visibility(make_ray_visibility(surface->mesh)),
        atlas(surface, static_cast<std::uint32_t>(std::max(views, capacity))),
        planner(atlas, *visibility, painted_room_planner()) {
    for (std::size_t number = 0; number < views; ++number) {
      const Camera camera = true_camera(number);
      planner.offer(std::to_string(number), camera, photograph_of(camera, *visibility, error));
    }
    planner.refiner().polish();
  }

  std::shared_ptr<const Surface> surface;
  std::unique_ptr<Visibility> visibility;
  Atlas atlas;
  Planner planner;
};

// By how many pixels a correction misses what undoes the error, at most, over a grid of the picture.
double miss_px(const LensCorrection& error, const LensCorrection& correction) {
  const Camera camera = true_camera(0);
  double most = 0;
  for (double x = 0; x <= camera.width; x += camera.width / 8.0) {
    for (double y = 0; y <= camera.height; y += camera.height / 6.0) {
      most = std::max(most, glm::distance(uncorrected(error, camera, {x, y}), uncorrected(correction, camera, {x, y})));
    }
  }
  return most;
}

void check_same(const LensEstimates& a, const LensEstimates& b) {
  REQUIRE(a.lenses.size() == b.lenses.size());
  for (std::size_t i = 0; i < a.lenses.size(); ++i) {
    CHECK(a.lenses[i].correction == b.lenses[i].correction);
    CHECK(a.lenses[i].deviation == b.lenses[i].deviation);
    CHECK(a.lenses[i].residual.after == b.lenses[i].residual.after);
  }
}

const LensEstimate& only_lens(const LensEstimates& estimates) {
  REQUIRE(estimates.lenses.size() == 1);
  return estimates.lenses.front();
}

TEST_CASE("what is wrong with a lens is found, believed, and gone once the photographs are made again") {
  struct Case {
    const char* what;
    LensCorrection error;
    double found_px, left_px;  // by how much an estimate, and its repetition, may miss
  };
  const auto [what, error, found_px, left_px] = GENERATE(Case{"focal length", {0.98, {0, 0}, 0, 0, 0, 0}, 0.5, 0.5},
                                                         Case{"k1", {1, {0, 0}, -0.05, 0, 0, 0}, 0.5, 0.5},
                                                         Case{"all", {1.01, {0.012, -0.012}, 0.04, 0, 0, 0}, 1, 0.5});
  CAPTURE(what);
  PaintedRoom room(kRoomViews, error);
  CHECK(room.planner.refiner().estimate_lenses({.most_points = 100}).undecided());
  const LensEstimates estimates = room.planner.refiner().estimate_lenses({.most_points = 1000});
  const LensEstimate& lens = only_lens(estimates);
  CAPTURE(lens.correction.focal, lens.correction.principal.x, lens.correction.k1, lens.correction.k2,
          lens.deviation.focal, lens.deviation.k1, lens.residual.before, lens.residual.after);
  CHECK(lens.slots.size() == room.planner.store().stored_views());
  CHECK(lens.significant);
  CHECK(lens.residual.after < 0.99 * lens.residual.before);
  CHECK(miss_px(error, lens.correction) < found_px);
  const double improvement = 1 - lens.residual.after / lens.residual.before;
  CHECK(
      only_lens(room.planner.refiner().estimate_lenses({.most_points = 1000, .least_improvement = 0.99 * improvement}))
          .significant);
  CHECK_FALSE(
      only_lens(room.planner.refiner().estimate_lenses({.most_points = 1000, .least_improvement = 1.01 * improvement}))
          .significant);
  CHECK(lens.corner_px == Approx(corner_move_px(lens.correction, true_camera(0))));

  LensCorrection total = lens.correction;
  const auto make_again = [&](std::uint32_t, const std::string& name) {
    return photograph_of(true_camera(std::stoul(name)), *room.visibility, error, total);
  };
  room.planner.refiner().correct_lenses(estimates, make_again);
  CHECK(room.atlas.view(0)->camera.fx == true_camera(0).fx);
  CHECK(room.atlas.view(0)->photograph->whole().rgb == make_again(0, room.atlas.view(0)->name).rgb);
  CHECK(room.atlas.view(0)->mask->depth == room.visibility->trace(room.atlas.view(0)->camera).depth);
  room.planner.refiner().polish();
  const LensEstimate again = only_lens(room.planner.refiner().estimate_lenses({.most_points = 1000}));
  CHECK(again.residual.after < lens.residual.before);
  if (again.significant) total = combined(total, again.correction);
  CHECK(miss_px(error, total) < left_px);
}

TEST_CASE("right lenses are left alone, and fewer points find the same less precisely") {
  const PaintedRoom room(kRoomViews, {});
  const LensEstimates all = room.planner.refiner().estimate_lenses();
  const LensEstimate& lens = only_lens(all);
  CAPTURE(lens.correction.focal, lens.deviation.focal, lens.correction.k1, lens.residual.before, lens.residual.after);
  CHECK(all.views > kRoomViews / 2);
  CHECK_FALSE(all.significant());
  CHECK_FALSE(all.undecided());
  CHECK(lens.correction.focal == Approx(1).margin(0.002));
  CHECK(lens.correction.k2 == 0);
  CHECK(lens.deviation.k2 == 0);
  CHECK(lens.correction.p1 == 0);

  const LensEstimates some = room.planner.refiner().estimate_lenses({.most_points = 300});
  CHECK(some.views == all.views);
  CHECK(some.points <= 300 * some.views);
  CHECK(some.points < all.points);
  CHECK(only_lens(some).deviation.focal > lens.deviation.focal);
  CHECK(only_lens(some).correction.focal == Approx(1).margin(0.004));
  CHECK_THROWS_AS(room.planner.refiner().estimate_lenses({.most_points = 0}), std::invalid_argument);
  for (const double share : {0.0, 1.0, std::nan("")}) {
    CHECK_THROWS_AS(room.planner.refiner().estimate_lenses({.least_improvement = share}), std::invalid_argument);
  }
}

TEST_CASE("few points do not clear a lens that is wrong in a term which is tried last") {
  const auto error = GENERATE(LensCorrection{1, {0, 0}, 0, 0.05, 0, 0}, LensCorrection{1, {0, 0}, 0, 0, 0.01, 0});
  const PaintedRoom room(kRoomViews, error);
  REQUIRE(corner_move_px(error, true_camera(0)) > 0.5);
  CHECK(room.planner.refiner().estimate_lenses({.most_points = 100}).undecided());
}

TEST_CASE("of two lenses the wrong one is corrected, the right one is left alone") {
  const LensCorrection error{1, {0, 0}, 0.05, 0, 0, 0};
  const auto surface = room_surface();
  const auto visibility = make_ray_visibility(surface->mesh);
  Atlas atlas(surface, 2 * kRoomViews);
  Planner planner(atlas, *visibility, painted_room_planner());
  const auto camera_of = [](std::size_t number) {
    return number % 2 == 0 ? true_camera(number / 2) : room_camera(number / 2).scaled_to(200, 150);
  };
  for (std::size_t number = 0; number < 2 * kRoomViews; ++number) {
    const Camera camera = camera_of(number);
    const LensCorrection lens = number % 2 == 0 ? LensCorrection{} : error;
    planner.offer(std::to_string(number), camera, photograph_of(camera, *visibility, lens));
  }
  planner.refiner().polish();
  const LensEstimates estimates = planner.refiner().estimate_lenses({.most_points = 500});
  REQUIRE(estimates.lenses.size() == 2);
  CHECK_FALSE(estimates.lenses[0].significant);
  CHECK(estimates.lenses[1].significant);
  CHECK(corner_move_px(estimates.lenses[0].correction, camera_of(0)) < 0.5);
  CHECK(miss_px(error, estimates.lenses[1].correction) < 1);
  const Camera right_before = atlas.view(0)->camera;
  planner.refiner().correct_lenses(estimates, [&](ViewSlot slot, const std::string& name) {
    CHECK(atlas.view(slot)->camera.width == 200);
    return photograph_of(camera_of(std::stoul(name)), *visibility, error, estimates.lenses[1].correction);
  });
  CHECK(atlas.view(0)->camera.cam_from_world_translation == right_before.cam_from_world_translation);
}

TEST_CASE("one view alone says nothing about its lens, and an empty store neither") {
  const PaintedRoom one(1, {0.98, {0, 0}, 0, 0, 0, 0});
  const LensEstimates estimates = one.planner.refiner().estimate_lenses();
  CHECK_FALSE(estimates.significant());
  CHECK(estimates.views == 0);
  CHECK(only_lens(estimates).correction == LensCorrection{});
  CHECK(estimates.cameras.size() == 1);

  const auto surface = room_surface();
  const auto visibility = make_ray_visibility(surface->mesh);
  Atlas atlas(surface, 3);
  const Planner empty(atlas, *visibility, painted_room_planner());
  CHECK(empty.refiner().estimate_lenses().lenses.empty());
}

TEST_CASE("what the atlas has room for makes no difference: as many unknowns, and the same estimate") {
  const LensCorrection error{0.98, {0, 0}, 0, 0, 0, 0};
  const PaintedRoom exact(6, error);
  const LensEstimates few = exact.planner.refiner().estimate_lenses();
  CHECK(few.unknowns == 7 + 7 * 6);
  const PaintedRoom roomy(6, error, 1280);
  const LensEstimates estimates = roomy.planner.refiner().estimate_lenses();
  CHECK(estimates.unknowns == few.unknowns);
  CHECK(estimates.points == few.points);
  CHECK(estimates.cameras.size() == 1280);
  check_same(few, estimates);
}

TEST_CASE("an estimate calls its cancel check many times, and what that throws ends it") {
  struct Stop {};
  const PaintedRoom room(6, {0.98, {0, 0}, 0, 0, 0, 0});
  std::atomic<int> calls = 0;
  LensOptions options;
  options.cancel_check = [&] { ++calls; };
  check_same(room.planner.refiner().estimate_lenses(options), room.planner.refiner().estimate_lenses());
  // Each view's comparison and its part of the normal equations, in at least two rounds of two passes.
  const int all = calls;
  CHECK(all > 2 * 2 * 2 * 6);
  for (const int last : {0, 5, all / 3, all - 1}) {
    calls = 0;
    options.cancel_check = [&] {
      if (++calls > last) throw Stop();
    };
    CHECK_THROWS_AS(room.planner.refiner().estimate_lenses(options), Stop);
    CHECK(calls < last + 100);  // those of other threads that were on their way
  }
}

TEST_CASE("the estimate is the same on one thread as on many") {
  const PaintedRoom room(8, {0.98, {0, 0}, 0, 0, 0, 0});
  const LensEstimates many = room.planner.refiner().estimate_lenses();
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  check_same(many, room.planner.refiner().estimate_lenses());
}

}  // namespace
}  // namespace lumatlas
