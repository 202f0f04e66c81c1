// SPDX-License-Identifier: GPL-3.0-or-later
// The poses of all stored views at once, on walks whose true poses are known.
#include "planner/refinement/pose_estimate.h"

#include <tbb/global_control.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "planner/planner.h"
#include "tests/support/scenes/relief_scenes.h"

namespace lumatlas {
namespace {

constexpr std::size_t kAllPoints = std::numeric_limits<std::size_t>::max();

PlannerOptions options_for_walk() {
  PlannerOptions options;
  options.coverage.ideal_distance = 4;
  options.min_view_gain = 0;
  options.visibility_px = 80;
  options.refinement.samples = 600;
  options.refinement.sample_px = 120;
  options.refinement.trust.enabled = false;
  options.refinement.revisits = 0;
  return options;
}

// Along the wall, near to it. Each view overlaps with few others, so that neighbours can agree with each other and be
// wrong together.
Camera walk_camera(std::size_t number, std::size_t views) {
  const double x = 3.2 * (2 * (static_cast<double>(number) + 0.5) / static_cast<double>(views) - 1);
  return relief_camera({x, 0.2 * std::sin(5 * x), 2.2}, {x + 0.2 * std::sin(3 * x), 0, 4});
}

struct Walk {
  Walk(std::size_t views, double px, const PlannerOptions& options)
      : atlas(relief.surface, static_cast<std::uint32_t>(views)), planner(atlas, *relief.visibility, options) {
    for (std::size_t number = 0; number < views; ++number) {
      truth.push_back(walk_camera(number, views));
      points.push_back(relief.points(truth.back(), 12, 9));
      given.push_back(px == 0 ? truth.back()
                              : disturbed(truth.back(), px, static_cast<std::uint32_t>(number), points.back()));
      planner.offer(std::to_string(number), given.back(), relief.photograph(truth.back()));
    }
    REQUIRE(planner.store().stored_views() == views);
  }

  [[nodiscard]] const Camera& stored(std::size_t number) const { return atlas.view(ViewSlot(slot(number)))->camera; }
  [[nodiscard]] std::uint32_t slot(std::size_t number) const {
    for (ViewSlot slot{0}; slot < atlas.capacity(); ++slot) {
      if (atlas.view(slot)->name == std::to_string(number)) return slot;
    }
    throw std::logic_error("no such view");
  }
  // Root mean square over the views.
  [[nodiscard]] double error_px() const {
    double sum = 0;
    for (std::size_t number = 0; number < truth.size(); ++number) {
      sum += std::pow(pose_error_px(stored(number), truth[number], points[number]), 2);
    }
    return std::sqrt(sum / static_cast<double>(truth.size()));
  }

  Relief relief;
  Atlas atlas;
  Planner planner;
  std::vector<Camera> truth, given;
  std::vector<std::vector<glm::dvec3>> points;
};

// Root mean square over the views of how far the two stores' poses are from each other.
double difference_px(const Walk& a, const Walk& b) {
  double sum = 0;
  for (std::size_t number = 0; number < a.truth.size(); ++number) {
    sum += std::pow(pose_error_px(a.stored(number), b.stored(number), a.points[number]), 2);
  }
  return std::sqrt(sum / static_cast<double>(a.truth.size()));
}

TEST_CASE("one solution for all poses is nearer to the truth than four steps of polishing") {
  Walk polished(36, 3, options_for_walk());
  Walk solved(36, 3, options_for_walk());
  for (int step = 0; step < 4; ++step) polished.planner.refiner().polish();
  polished.planner.refiner().publish_refined();
  solved.planner.refiner().polish();
  const PoseEstimate estimate = solved.planner.refiner().solve_poses(kAllPoints);
  solved.planner.refiner().publish_refined();
  CAPTURE(polished.error_px(), solved.error_px(), estimate.residual_before, estimate.residual_after);
  CHECK(estimate.views == 36);
  CHECK(estimate.points > 36 * 100);
  CHECK(estimate.improves());
  CHECK(estimate.residual_after < 0.95 * estimate.residual_before);
  CHECK(solved.error_px() < 0.95 * polished.error_px());
  // The set as a whole stays where the given poses put it.
  glm::dvec3 moved(0);
  for (std::size_t number = 0; number < 36; ++number) {
    moved += (solved.stored(number).center() - solved.given[number].center()) / 36.0;
  }
  CHECK(glm::length(moved) < 0.0007);
  // A second solution finds nothing more.
  const PoseEstimate second = solved.planner.refiner().solve_poses(kAllPoints);
  CHECK(second.residual_after > 0.97 * estimate.residual_after);
}

TEST_CASE("where poses are right a solution leaves them, and so does one without refinement of poses") {
  Walk exact(12, 0, options_for_walk());
  CHECK(exact.planner.refiner().solve_poses(kAllPoints).views == 12);
  exact.planner.refiner().publish_refined();
  CHECK(exact.error_px() < 0.05);

  PlannerOptions exposure_alone = options_for_walk();
  exposure_alone.refinement.alignment.pose = false;
  Walk given(12, 3, exposure_alone);
  CHECK(given.planner.refiner().solve_poses(kAllPoints).views == 0);
  given.planner.refiner().publish_refined();
  for (std::size_t number = 0; number < 12; ++number) CHECK(same_pose(given.stored(number), given.given[number]));
}

TEST_CASE("no view moves further than it may") {
  PlannerOptions options = options_for_walk();
  options.refinement.alignment.max_move = 0.015;  // 3.6 pixels, of a corner
  options.refinement.alignment.prior = 0;
  Walk walk(24, 3, options);
  CHECK(walk.planner.refiner().solve_poses(kAllPoints).improves());
  walk.planner.refiner().publish_refined();
  std::size_t moved = 0;
  for (std::size_t number = 0; number < 24; ++number) {
    moved += !same_pose(walk.stored(number), walk.given[number]);
    CHECK(pose_error_px(walk.stored(number), walk.given[number], walk.points[number]) < 1.1 * 3.6);
  }
  CAPTURE(moved);
  CHECK(moved > 2);
  CHECK(moved < 22);
}

TEST_CASE("fewer points are fitted to where fewer are asked for, and none are refused") {
  Walk walk(12, 2, options_for_walk());
  const PoseEstimate all = walk.planner.refiner().solve_poses(kAllPoints);
  const PoseEstimate some = walk.planner.refiner().solve_poses(100);
  CHECK(some.views == 12);
  CHECK(some.points <= 100 * some.views);
  CHECK(some.points < all.points);
  CHECK_THROWS_AS(walk.planner.refiner().solve_poses(0), std::invalid_argument);
}

TEST_CASE("a store of one view, or of none, has nothing to be solved for") {
  Walk one(1, 3, options_for_walk());
  const PoseEstimate estimate = one.planner.refiner().solve_poses(kAllPoints);
  CHECK(estimate.views == 0);
  CHECK_FALSE(estimate.improves());
  one.planner.refiner().publish_refined();
  CHECK(same_pose(one.stored(0), one.given[0]));
  const Relief relief;
  Atlas atlas(relief.surface, 3);
  Planner empty(atlas, *relief.visibility, options_for_walk());
  CHECK(empty.refiner().solve_poses(kAllPoints).views == 0);
}

TEST_CASE("a solution can be stopped, and the store is whole after") {
  struct Stop {};
  PlannerOptions options = options_for_walk();
  std::atomic<int> calls_left = std::numeric_limits<int>::max();
  options.refinement.cancel_check = [&] {
    if (--calls_left < 0) throw Stop();
  };
  Walk walk(8, 2, options);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  Walk other(8, 2, options);
  const int before = calls_left;
  other.planner.refiner().solve_poses(kAllPoints);
  const int calls = before - calls_left;
  for (const int last : {0, 5, calls / 2, calls - 4}) {
    calls_left = last;
    CHECK_THROWS_AS(walk.planner.refiner().solve_poses(kAllPoints), Stop);
    for (std::size_t number = 0; number < 8; ++number) {
      const auto view = walk.atlas.view(ViewSlot(walk.slot(number)));
      CHECK(view->mask->depth == walk.relief.visibility->trace(view->camera).depth);
    }
  }
  calls_left = std::numeric_limits<int>::max();
  CHECK(walk.planner.refiner().solve_poses(kAllPoints).improves());
}

TEST_CASE("the solution is the same on one thread as on many") {
  Walk many(8, 2, options_for_walk());
  Walk one(8, 2, options_for_walk());
  const PoseEstimate of_many = many.planner.refiner().solve_poses(kAllPoints);
  REQUIRE(of_many.improves());
  many.planner.refiner().publish_refined();
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  CHECK(one.planner.refiner().solve_poses(kAllPoints).residual_after == of_many.residual_after);
  one.planner.refiner().publish_refined();
  CHECK(difference_px(many, one) == 0);
}

}  // namespace
}  // namespace lumatlas
