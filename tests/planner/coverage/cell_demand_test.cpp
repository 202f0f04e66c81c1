// SPDX-License-Identifier: GPL-3.0-or-later
// What the stream asks for, from one cell to the planner.
#include "planner/coverage/cell_demand.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <map>
#include <random>

#include "planner/coverage/coverage_ledger.h"
#include "planner/coverage/direction_coverage.h"
#include "planner/planner.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

Contribution seen_from(double distance, double picture_share) {
  Contribution part;
  part.direction = {0, 0, 1};
  part.distance = distance;
  part.cell_share = 1;
  part.picture_share = picture_share;
  return part;
}

CellDemand demand_of(const std::vector<Contribution>& parts) {
  CellDemand demand;
  for (const Contribution& part : parts) demand.add(part);
  return demand;
}

// Half a step of an eighth of an octave.
const double kHalfStep = std::exp2(1.0 / 16);

TEST_CASE("a cell's demand equals one worked by hand") {
  const CellDemand demand = demand_of({seen_from(1, 0.25), seen_from(4, 0.5)});
  CHECK(demand.weight(0) == Approx(0.375));
  CHECK(demand.weight(2) == Approx(0.1875));
  // log2: (0.25 * 0 + 0.5 * 2) / 0.75 = 1.333 octaves, to the nearest eighth 1.375.
  CHECK(demand.ideal_distance() == Approx(std::exp2(1.375)));
}

TEST_CASE("a cell that no view sees, or only from its centroid, has no demand") {
  CHECK(CellDemand().weight(0) == 0);
  CHECK(CellDemand().weight(10) == 0);
  CHECK(CellDemand().ideal_distance() == 0);
  const CellDemand demand = demand_of({Contribution{}, seen_from(0, 0.5)});
  CHECK(demand.weight(10) == 0);
  CHECK(demand.ideal_distance() == 0);
}

TEST_CASE("demand is the same in any order, and a view that is taken back leaves no trace") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int round = 0; round < 20; ++round) {
    std::vector<Contribution> parts;
    for (int i = 0; i < 50; ++i) parts.push_back(seen_from(std::exp(8 * uniform(random) - 4), uniform(random)));
    CellDemand demand = demand_of(parts);
    std::shuffle(parts.begin(), parts.end(), random);
    while (parts.size() > 20) {
      demand.remove(parts.back());
      parts.pop_back();
    }
    std::reverse(parts.begin(), parts.end());
    CHECK(demand.weight(7) == demand_of(parts).weight(7));
    CHECK(demand.ideal_distance() == demand_of(parts).ideal_distance());
  }
}

TEST_CASE("a cell weighs at most its largest share of a picture, and is asked for within the distances of its views") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(0.01, 1);
  for (int round = 0; round < 50; ++round) {
    CellDemand demand;
    double most = 0, nearest = 1e9, farthest = 0;
    for (int i = 0; i < 30; ++i) {
      const Contribution part = seen_from(5 * uniform(random), uniform(random));
      demand.add(part);
      most = std::max(most, part.picture_share);
      nearest = std::min(nearest, part.distance);
      farthest = std::max(farthest, part.distance);
      CHECK(demand.weight(0) <= most + 1e-7);  // shares are rounded to 24 bits
      CHECK(demand.weight(10) < demand.weight(0));
      CHECK(demand.ideal_distance() >= nearest / kHalfStep * (1 - 1e-3));
      CHECK(demand.ideal_distance() <= farthest * kHalfStep * (1 + 1e-3));
    }
  }
}

TEST_CASE("a camera that stands still for long asks for no more than one that looks once") {
  CellDemand demand = demand_of({seen_from(2, 0.01), seen_from(2, 0.01)});
  for (int frame = 0; frame < 1'000'000; ++frame) demand.add(seen_from(0.5, 0.2));
  CHECK(demand.weight(10) <= 0.2);
  CHECK(demand.ideal_distance() == Approx(0.5));
}

TEST_CASE("where all lengths are scaled, so is the distance that a cell is asked for from") {
  const std::vector<double> distances{1.2, 3.1, 0.7};
  for (const double scale : {1.0 / 1024, 8.0, 1e6}) {
    CellDemand small, large;
    for (const double distance : distances) {
      small.add(seen_from(distance, 0.1));
      large.add(seen_from(scale * distance, 0.1));
    }
    CHECK(large.weight(1) == small.weight(1));
    CHECK(large.ideal_distance() / scale == Approx(small.ideal_distance()).epsilon(0.1));  // a step
  }
}

CoverageOptions options_of(std::uint32_t directions, std::uint32_t views) {
  CoverageOptions options;
  options.ideal_distance = 100;  // not to be looked at
  options.directions = directions;
  options.views_per_direction = views;
  return options;
}

TEST_CASE("what a cell is worth follows what is asked of it, as worked by hand") {
  CoverageOptions options = options_of(1, 1);
  options.lambda = 0;  // q = cov_p
  options.demand_prior = 0;
  const std::shared_ptr<const Surface> surface = room_surface();
  DirectionCoverage coverage(*surface, options, 0);
  const Contribution near = seen_from(2, 0.25), far = seen_from(8, 0.25);
  std::vector<double> losses(1, 0);
  const auto change_demand = [&](const Contribution& part, DemandChange change = DemandChange::add) {
    const double before = coverage.value(0);
    const double rise = coverage.change_demand(0, part, change, losses);
    CHECK(rise == Approx(coverage.value(0) - before).margin(1e-9));
    CHECK(losses[0] == Approx(coverage.value(0)).margin(1e-9));  // of the only view
  };
  coverage.insert(0, 0, near, losses);
  CHECK(coverage.value(0) == 0);  // nobody asked
  CHECK(coverage.gain(0, near, {}, {}) == 0);
  change_demand(near);
  CHECK(coverage.weight(0) == Approx(0.25));
  CHECK(coverage.value(0) == Approx(0.25));  // at the very distance
  change_demand(far);
  // Asked for from sqrt(2 * 8) = 4, with a sigma of 2: one sigma off.
  CHECK(coverage.value(0) == Approx(0.25 * std::exp(-0.5)).epsilon(1e-5));
  // A view from 4 is worth all that there is.
  const Contribution middle = seen_from(4, 0.25);
  CHECK(coverage.gain(0, middle, {}, {}) == Approx(0.25 * (1 - std::exp(-0.5))).epsilon(1e-5));
  CHECK(coverage.value_by_definition(0, {}, &middle) == Approx(0.25).epsilon(1e-5));
  change_demand(far, DemandChange::remove);
  CHECK(coverage.value(0) == Approx(0.25));
  change_demand(near, DemandChange::remove);
  CHECK(coverage.value(0) == 0);
}

TEST_CASE("a measure without demand does not listen to what is asked for") {
  const std::shared_ptr<const Surface> surface = room_surface();
  CoverageOptions without = options_of(8, 2);
  without.demand = false;
  without.ideal_distance = 2;
  CoverageOptions paper = CoverageOptions::printed();
  paper.ideal_distance = 2;
  for (const CoverageOptions& options : {without, paper}) {
    CoverageLedger ledger(*surface, 2, options, 0);
    const std::vector<CellPart> parts{{0, {{0, 0, 1}, 0.5, 2, 0.5, 0.1}}, {3, {{0, 0, 1}, 0.7, 2, 0.7, 0.2}}};
    CHECK(ledger.weight(parts) == 2);
    ledger.insert(0, parts);
    const double before = ledger.summed_coverage();
    ledger.add_demand(parts);
    CHECK(ledger.summed_coverage() == before);
    CHECK(ledger.weight(parts) == 2);
  }
}

PlannerOptions options_for_demand() {
  PlannerOptions options;
  options.coverage.ideal_distance = 2;
  options.coverage.max_references = 4;
  options.visibility_px = 64;
  options.refinement.alignment.pose = options.refinement.alignment.exposure = false;
  return options;
}

struct PlannedByDemand {
  explicit PlannedByDemand(std::uint32_t slots, const PlannerOptions& planner_options = options_for_demand())
      : options(planner_options),
        surface(room_surface()),
        visibility(make_ray_visibility(surface->mesh)),
        atlas(surface, slots),
        planner(atlas, *visibility, options) {}
  Verdict offer(std::size_t number) {
    const Camera camera = room_camera(number);
    asked.push_back(planner.parts_of(camera));
    const Verdict verdict = planner.offer(std::to_string(number), camera, pattern_photograph(camera, number));
    if (verdict.slot) stored[*verdict.slot] = asked.back();
    return verdict;
  }
  // scov of what is stored, from all that was offered, in another order.
  [[nodiscard]] double coverage_from_scratch() const {
    CoverageLedger ledger(*surface, atlas.capacity(), options.coverage, options.min_reference_gain);
    for (const auto& [slot, parts] : stored) ledger.insert(ViewSlot(slot), parts);
    std::for_each(asked.rbegin(), asked.rend(), [&](const auto& parts) { ledger.add_demand(parts); });
    return ledger.summed_coverage();
  }

  PlannerOptions options;
  std::shared_ptr<const Surface> surface;
  std::unique_ptr<Visibility> visibility;
  Atlas atlas;
  Planner planner;
  std::vector<std::vector<CellPart>> asked;
  std::map<std::uint32_t, std::vector<CellPart>> stored;
};

TEST_CASE("after hundreds of offers a store is worth what it would be if all had been asked for from the start") {
  PlannedByDemand scene(5);
  std::mt19937 random(6);
  std::size_t replaced = 0;
  for (int i = 0; i < 300; ++i) {
    replaced += scene.offer(random() % 200).decision == Decision::replaced;
    if (i % 30 == 29)
      CHECK(scene.planner.store().summed_coverage() == Approx(scene.coverage_from_scratch()).margin(1e-6));
  }
  CHECK(replaced > 5);  // else exchanges were not tested
}

TEST_CASE("a view that is passed by asks for as much as one that is rejected") {
  PlannerOptions options = options_for_demand();
  options.min_view_gain = 10;  // rejects all
  PlannedByDemand offered(3, options), passed(3, options);
  const Camera kept = room_camera(0);
  for (PlannedByDemand* scene : {&offered, &passed}) {
    scene->planner.force_store("kept", kept, [&] { return pattern_photograph(kept, 0); });
  }
  const double alone = offered.planner.store().summed_coverage();
  for (std::size_t i = 1; i < 20; ++i) {
    REQUIRE(offered.offer(i).decision == Decision::rejected);
    passed.planner.count_demand(room_camera(i));
  }
  CHECK(passed.planner.store().summed_coverage() == offered.planner.store().summed_coverage());
  CHECK(passed.planner.store().summed_coverage() != alone);
  CHECK(passed.atlas.size() == 1);
}

TEST_CASE("a camera that stands still for long does not drive the views of other places out of the store") {
  PlannedByDemand scene(6);
  for (std::size_t i = 0; i < 60; ++i) scene.offer(i);
  REQUIRE(scene.atlas.size() == 6);
  std::size_t taken = 0;
  for (int frame = 0; frame < 300; ++frame) taken += scene.offer(33).decision != Decision::rejected;
  CHECK(taken <= scene.options.coverage.views_per_direction);
}

}  // namespace
}  // namespace lumatlas
