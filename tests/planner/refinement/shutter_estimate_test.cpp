// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs that a rolling shutter read while the camera turned, of a room whose colours are known everywhere.
#include "planner/refinement/shutter_estimate.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "mesh/base/median.h"
#include "planner/planner.h"
#include "tests/planner/refinement/painted_room.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

constexpr std::size_t kViews = 13;

// A turn of some pixels, another one for each photograph.
ShutterMotion motion_of_view(std::size_t number, double px) {
  const double size = px / painted_camera(0).fx, i = static_cast<double>(number);
  return {size * glm::dvec3(std::sin(2.3 * i), std::cos(1.7 * i), 0.5 * std::sin(3.1 * i + 1)), glm::dvec3(0)};
}

// The place that a camera at rest shows where the moving one shows `read`, by fixed-point iteration.
glm::dvec2 at_rest(const ShutterMotion& motion, const Camera& camera, const glm::dvec2& read) {
  glm::dvec2 guess = read;
  for (int i = 0; i < 10; ++i) guess -= when_read(motion, camera, guess) - read;
  return guess;
}

struct TurningRoom {
  TurningRoom(double px, std::size_t capacity = kViews)
      : surface(room_surface()),
        visibility(make_ray_visibility(surface->mesh)),
        atlas(surface, static_cast<std::uint32_t>(capacity)),
        planner(atlas, *visibility, painted_room_planner()),
        turn_px(px) {
    for (std::size_t number = 0; number < kViews; ++number) {
      planner.offer(std::to_string(number), painted_camera(number), photograph(number, {}));
    }
    planner.refiner().polish();
  }

  // Returns the photograph that the file gives once it is straightened by a motion.
  [[nodiscard]] Photograph photograph(std::size_t number, const ShutterMotion& straightened_by) const {
    const Camera camera = painted_camera(number);
    const ShutterMotion motion = motion_of_view(number, turn_px);
    return painted_photograph(camera, *visibility, [&](const glm::dvec2& pixel) {
      return at_rest(motion, camera, when_read(straightened_by, camera, pixel));
    });
  }

  // Returns the pixels by which estimated motions miss the true ones: the median over the views of the most over a
  // picture.
  [[nodiscard]] double miss_px(const std::vector<ShutterMotion>& motions) const {
    std::vector<double> misses;
    for (ViewSlot slot{0}; slot < atlas.capacity(); ++slot) {
      if (!atlas.view(slot)) continue;
      const std::size_t number = std::stoul(planner.store().name_of(slot));
      const Camera camera = painted_camera(number);
      const ShutterMotion truth = motion_of_view(number, turn_px);
      double most = 0;
      for (double x = 0; x <= camera.width; x += camera.width / 8.0) {
        for (double y = 0; y <= camera.height; y += camera.height / 6.0) {
          most = std::max(most, glm::distance(when_read(motions[slot], camera, glm::dvec2(x, y)),
                                              when_read(truth, camera, glm::dvec2(x, y))));
        }
      }
      misses.push_back(most);
    }
    return upper_median(misses);
  }

  std::shared_ptr<const Surface> surface;
  std::unique_ptr<Visibility> visibility;
  Atlas atlas;
  Planner planner;
  double turn_px;
};

TEST_CASE("turns of cameras while their shutters read are found, and gone once the photographs are straightened") {
  TurningRoom room(8);
  const double at_first = room.miss_px(std::vector<ShutterMotion>(kViews));
  REQUIRE(at_first > 2);
  const ShutterEstimate estimate = room.planner.refiner().estimate_shutters({.most_points = 1000});
  CAPTURE(at_first, room.miss_px(estimate.motions), estimate.residual.before, estimate.residual.after,
          estimate.median_px);
  CHECK(estimate.views == room.planner.store().stored_views());
  CHECK(estimate.significant);
  CHECK(estimate.median_px > 1);
  CHECK(estimate.residual.after < 0.8 * estimate.residual.before);
  CHECK(room.miss_px(estimate.motions) < 0.5 * at_first);

  std::vector<ShutterMotion> total = estimate.motions;
  room.planner.refiner().correct_shutters(
      estimate, [&](ViewSlot slot, const std::string& name) { return room.photograph(std::stoul(name), total[slot]); });
  CHECK(room.atlas.view(0)->photograph->whole().rgb ==
        room.photograph(std::stoul(room.atlas.view(0)->name), total[0]).rgb);
  room.planner.refiner().polish();
  const ShutterEstimate again =
      room.planner.refiner().estimate_shutters({.most_points = 1000, .least_improvement = 0.003});
  for (std::size_t slot = 0; slot < total.size(); ++slot) {
    total[slot].turn += again.motions[slot].turn;
    total[slot].shift += again.motions[slot].shift;
  }
  CAPTURE(room.miss_px(total), again.residual.after);
  CHECK(again.median_px < 0.5 * estimate.median_px);
  CHECK(room.miss_px(total) <= room.miss_px(estimate.motions));
}

TEST_CASE("photographs of cameras at rest are left alone") {
  TurningRoom room(0);
  const ShutterEstimate estimate = room.planner.refiner().estimate_shutters();
  CAPTURE(estimate.median_px, estimate.residual.before, estimate.residual.after);
  CHECK_FALSE(estimate.significant);
  CHECK(estimate.median_px < 0.5);
  room.planner.refiner().correct_shutters(estimate, [](ViewSlot, const std::string&) -> Photograph {
    throw std::logic_error("no photograph has changed");
  });
}

TEST_CASE("too few points and wrong options are told") {
  TurningRoom room(0, kViews + 5);
  const ShutterEstimate none = room.planner.refiner().estimate_shutters({.most_operations = 0});
  CHECK_FALSE(none.significant);
  CHECK(none.motions.size() == kViews + 5);
  CHECK_THROWS_AS(room.planner.refiner().estimate_shutters({.most_points = 0}), std::invalid_argument);
  for (const double share : {0.0, 1.0, std::nan("")}) {
    CHECK_THROWS_AS(room.planner.refiner().estimate_shutters({.least_improvement = share}), std::invalid_argument);
  }
  ShutterEstimate short_one = none;
  short_one.cameras.pop_back();
  CHECK_THROWS_AS(room.planner.refiner().correct_shutters(short_one, {}), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
