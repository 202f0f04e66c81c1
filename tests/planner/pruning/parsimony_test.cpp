// SPDX-License-Identifier: GPL-3.0-or-later
// A store that is as small as a bound on the predicted loss allows.
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>

#include "planner/coverage/direction_coverage.h"
#include "planner/coverage/offered_coverage.h"
#include "planner/coverage/predicted_loss.h"
#include "planner/planner.h"
#include "planner/pruning/hindsight.h"
#include "planner/pruning/pruning.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

CoverageOptions coverage_for_room(bool demand) {
  CoverageOptions options = parsimony_coverage({});
  options.ideal_distance = 2;
  options.demand = demand;
  return options;
}

PlannerOptions options_for_room(std::optional<double> max_loss_db) {
  PlannerOptions options;
  options.coverage = coverage_for_room(true);
  options.coverage.max_references = 64;
  options.visibility_px = 64;
  options.min_view_gain = 0;
  options.max_loss_db = max_loss_db;
  options.refinement.alignment.pose = options.refinement.alignment.exposure = false;
  return options;
}

struct Stream {
  explicit Stream(std::optional<double> max_loss_db, std::uint32_t slots = 300)
      : surface(room_surface()),
        visibility(make_ray_visibility(surface->mesh)),
        atlas(surface, slots),
        planner(atlas, *visibility, options_for_room(max_loss_db)) {}
  Verdict offer(const Camera& camera) {
    return planner.offer("view " + std::to_string(offered++), camera, pattern_photograph(camera, 1));
  }
  void walk(std::size_t views) {
    for (std::size_t i = 0; i < views; ++i) offer(room_camera(i));
  }
  // Slots and names of what is stored.
  [[nodiscard]] std::vector<std::string> stored() const {
    std::vector<std::string> names;
    for (const auto& view : atlas.snapshot().views) names.push_back(view ? view->name : "");
    return names;
  }

  std::shared_ptr<const Surface> surface;
  std::unique_ptr<Visibility> visibility;
  Atlas atlas;
  Planner planner;
  std::size_t offered = 0;
};

// A view that sees a random half of the room's cells, from anywhere in front of them.
std::vector<CellPart> random_parts(std::mt19937& random, const Surface& surface) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<CellPart> parts;
  for (CellId cell{0}; cell < surface.cells.cells.size(); ++cell) {
    if (random() % 2 == 0) continue;
    const glm::dvec3 anywhere(uniform(random), uniform(random), uniform(random));
    const double cell_share = 0.5 + 0.5 * uniform(random), distance = 2 + uniform(random);
    parts.push_back({CellId{cell},
                     {glm::normalize(anywhere + 1.5 * surface.cells.cells[cell].normal),
                      positional_coverage(distance, cell_share, 2, {}), distance, cell_share, 0.05}});
  }
  return parts;
}

// Qualities are single precision.
constexpr double kRounding = 1e-5;

TEST_CASE("what all offered views are worth is what a store of them all is worth, though most are forgotten") {
  const auto surface = room_surface();
  const CoverageOptions options = coverage_for_room(false);
  std::mt19937 random(3);
  constexpr std::uint32_t kViews = 300, kStored = 20;
  OfferedCoverage offered(*surface, options);
  CoverageLedger everything(*surface, kViews, options, 0), store(*surface, kStored, options, 0);
  for (std::uint32_t view = 0; view < kViews; ++view) {
    const std::vector<CellPart> parts = random_parts(random, *surface);
    offered.add(parts);
    everything.insert(ViewSlot(view), parts);
    if (view % (kViews / kStored) == 0) store.insert(ViewSlot(view / (kViews / kStored)), parts);
  }
  CHECK(offered.gap(store) == Approx(1 - store.summed_coverage() / everything.summed_coverage()).margin(kRounding));
  CHECK(offered.gap(store) > 0.1);
  CHECK(offered.gap(everything) == Approx(0).margin(kRounding));
}

TEST_CASE("a view more that is not kept widens the gap as it does once it is added, and one less as once it has left") {
  const auto surface = room_surface();
  const CoverageOptions options = coverage_for_room(false);
  std::mt19937 random(4);
  OfferedCoverage offered(*surface, options);
  CoverageLedger store(*surface, 10, options, 0);
  for (std::uint32_t view = 0; view < 10; ++view) {
    const std::vector<CellPart> parts = random_parts(random, *surface);
    offered.add(parts);
    store.insert(ViewSlot(view), parts);
  }
  REQUIRE(offered.gap(store) == 0);
  const std::vector<CellPart> newcomer = random_parts(random, *surface);
  const double foreseen = offered.gap(store, newcomer);
  offered.add(newcomer);
  CHECK(foreseen > 0.01);
  CHECK(offered.gap(store) == Approx(foreseen).margin(kRounding));
  const double without = offered.gap_without(store, 3);
  store.erase(3);
  CHECK(without > foreseen);
  CHECK(offered.gap(store) == Approx(without).margin(kRounding));
}

TEST_CASE("what is held of the offered views does not grow with the stream") {
  const auto surface = room_surface();
  const CoverageOptions options = coverage_for_room(true);
  std::mt19937 random(5);
  OfferedCoverage offered(*surface, options);
  std::size_t most_early = 0, most_late = 0;
  for (int view = 0; view < 1200; ++view) {
    const std::vector<CellPart> parts = random_parts(random, *surface);
    offered.add_demand(parts);
    offered.add(parts);
    for (const CellPart& entry : parts) {
      const std::size_t held = offered.held(entry.cell);
      REQUIRE(held <= (options.views_per_direction + 1) * options.directions);
      (view < 600 ? most_early : most_late) = std::max(view < 600 ? most_early : most_late, held);
    }
  }
  CHECK(most_early < 100);  // of 300 in the mean that saw a cell until then
  CHECK(10 * most_late < 13 * most_early);
}

TEST_CASE("with a bound of 0 everything is kept that adds, and nothing is predicted to be lost") {
  Stream stream(0.0);
  std::size_t adding = 0;
  for (std::size_t i = 0; i < 40; ++i) adding += stream.offer(room_camera(i)).gain > 0;
  CHECK(adding == 40);
  CHECK(Pruning(stream.planner).prune().empty());
  CHECK(stream.planner.store().stored_views() == 40);
  CHECK(Pruning(stream.planner).predicted_loss().gap == 0);
  CHECK(Pruning(stream.planner).predicted_loss().loss_db == 0);
}

TEST_CASE("a larger bound keeps fewer views, and the prediction stays within each") {
  std::uint32_t last = 61;
  for (const double bound : {0.0, 0.05, 0.2, 0.8, 3.0, 20.0}) {
    Stream stream(bound);
    stream.walk(60);
    const std::uint32_t before = stream.planner.store().stored_views();
    const std::size_t gone = Pruning(stream.planner).prune().size();
    CAPTURE(bound, before, gone);
    CHECK(stream.planner.store().stored_views() + gone == before);
    CHECK(stream.planner.store().stored_views() < last);
    CHECK(Pruning(stream.planner).predicted_loss().loss_db <= bound);
    CHECK_FALSE(Pruning(stream.planner).predicted_loss().short_of_room);
    last = stream.planner.store().stored_views();
  }
  CHECK(last >= 1);
  CHECK(last < 8);
}

TEST_CASE("no view can be taken away any more once the store is thinned") {
  Stream stream(0.3);
  stream.walk(60);
  CHECK_FALSE(Pruning(stream.planner).prune().empty());
  CHECK(Pruning(stream.planner).prune().empty());
}

TEST_CASE("of a camera that stands still no more views are kept than a direction counts") {
  Stream stream(0.1);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> tremble(-1e-4, 1e-4);  // of a room of 4
  for (int frame = 0; frame < 200; ++frame) {
    Camera camera = room_camera(0);
    camera.cam_from_world_translation += glm::dvec3(tremble(random), tremble(random), tremble(random));
    stream.offer(camera);
  }
  Pruning(stream.planner).prune();
  CHECK(stream.planner.store().stored_views() >= 1);
  CHECK(stream.planner.store().stored_views() <= coverage_for_room(true).views_per_direction);
}

TEST_CASE("a view of nothing is not kept, whatever the bound") {
  for (const double bound : {0.0, 0.1}) {
    Stream stream(bound);
    Camera away = room_camera(0);
    away.cam_from_world_rotation = glm::dmat3(1);
    away.cam_from_world_translation = {500, 500, 500};
    CHECK(stream.offer(away).decision == Decision::rejected);
    CHECK(Pruning(stream.planner).prune().empty());
    CHECK(stream.planner.store().stored_views() == 0);
    CHECK(Pruning(stream.planner).predicted_loss().loss_db == 0);
  }
}

TEST_CASE("a store without room for what is needed says so, and predicts more than the bound") {
  Stream stream(0.1, 4);
  stream.walk(60);
  CHECK(Pruning(stream.planner).prune().empty());
  const PredictedLoss predicted = Pruning(stream.planner).predicted_loss();
  CHECK(predicted.short_of_room);
  CHECK(predicted.loss_db > 0.1);
  CHECK(stream.planner.store().stored_views() == 4);
}

TEST_CASE("a thinned store is the same on one thread as on many") {
  Stream many(0.3);
  many.walk(60);
  const std::vector<std::string> gone = Pruning(many.planner).prune();
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  Stream one(0.3);
  one.walk(60);
  CHECK(Pruning(one.planner).prune() == gone);
  CHECK(one.stored() == many.stored());
  CHECK(Pruning(one.planner).predicted_loss().loss_db == Pruning(many.planner).predicted_loss().loss_db);
  CHECK(one.atlas.snapshot().references.views == many.atlas.snapshot().references.views);
}

TEST_CASE("a larger bound leaves fewer references, one of 0 all, and the prediction counts them within it") {
  Stream all(0.0);
  all.walk(60);
  Pruning(all.planner).prune();
  CHECK(Pruning(all.planner).predicted_loss().references_given_up == 0);
  CHECK(Pruning(all.planner).predicted_loss().reference_gap == 0);
  std::size_t last = all.atlas.snapshot().references.views.size();
  for (const double bound : {0.1, 0.4, 1.6}) {
    Stream stream(bound);
    stream.walk(60);
    Pruning(stream.planner).prune();
    const PredictedLoss predicted = Pruning(stream.planner).predicted_loss();
    CAPTURE(bound);
    CHECK(predicted.references_given_up > 0);
    CHECK(predicted.reference_gap > 0);
    CHECK(predicted.loss_db <= bound);
    CHECK(predicted.loss_db == predicted_loss_db(predicted.gap) + predicted_reference_loss_db(predicted.reference_gap));
    const Snapshot snapshot = stream.atlas.snapshot();
    for (const ViewSlot slot : snapshot.references.views) REQUIRE(snapshot.views[slot]);
    const std::size_t kept = snapshot.references.views.size();
    CHECK(kept + predicted.references_given_up < last);
    last = kept;
  }
}

TEST_CASE("what a cell loses by giving up references is what its service falls by, and grows from one to the next") {
  const auto surface = room_surface();
  std::mt19937 random(7);
  DirectionCoverage coverage(*surface, coverage_for_room(false), 0);
  for (std::uint32_t view = 0; view < 12; ++view) {
    for (const CellPart& entry : random_parts(random, *surface))
      coverage.insert(entry.cell, ViewSlot(view), entry.part);
  }
  std::size_t given_up = 0;
  for (CellId cell{0}; cell < surface->cells.cells.size(); ++cell) {
    const double before = coverage.reference_service(cell).of_kept;
    const std::size_t references = coverage.references(cell).size();
    double lost = 0, last = 0;
    for (const ReferenceLoss& next : coverage.reference_losses(cell)) {
      CHECK(next.loss >= last - kRounding);
      last = next.loss;
      lost += next.loss;
      coverage.give_up(cell, std::array{next.slot});
      ++given_up;
      CHECK(coverage.reference_service(cell).of_kept == Approx(before - lost).margin(kRounding));
      CHECK(coverage.reference_service(cell).of_all == Approx(before).margin(kRounding));
    }
    CHECK(coverage.references(cell).size() == std::min<std::size_t>(references, 3));
  }
  CHECK(given_up > 20);
}

std::vector<ViewSlot> slots_of(const std::vector<ThinningStep>& order) {
  std::vector<ViewSlot> slots;
  for (const ThinningStep& step : order) slots.push_back(step.slot);
  std::sort(slots.begin(), slots.end());
  return slots;
}

TEST_CASE("the order of thinning names every view once, and the gap that each leaves is what the store comes to") {
  Stream stream(0.0);
  stream.walk(30);
  const double whole = stream.planner.store().summed_coverage();
  const std::vector<ThinningStep> order = Hindsight(stream.planner).thinning_order();
  std::vector<ViewSlot> all(30);
  std::iota(all.begin(), all.end(), ViewSlot{0});
  CHECK(slots_of(order) == all);
  CHECK(stream.planner.store().stored_views() == 30);
  double last = 0;
  for (const ThinningStep& step : order) {
    CHECK(step.gap >= last);
    last = step.gap;
    Pruning(stream.planner).evict(std::array{step.slot});
    CHECK(1 - stream.planner.store().summed_coverage() / whole == Approx(step.gap).margin(kRounding));
  }
  CHECK(last == Approx(1));
  CHECK(stream.planner.store().stored_views() == 0);
  CHECK(Hindsight(stream.planner).thinning_order().empty());
}

TEST_CASE("views that are absent count as never offered where a store is thinned without them") {
  Stream all(0.0);
  all.walk(24);
  const std::vector<ViewSlot> absent{3, 11, 19};
  const std::vector<ThinningStep> order = Hindsight(all.planner).thinning_order(absent);
  Stream others(0.0);
  for (std::size_t i = 0; i < 24; ++i) {
    if (std::find(absent.begin(), absent.end(), i) == absent.end()) others.offer(room_camera(i));
  }
  const std::vector<ThinningStep> expected = Hindsight(others.planner).thinning_order();
  REQUIRE(order.size() == 21);
  REQUIRE(expected.size() == 21);
  for (std::size_t i = 0; i < order.size(); ++i) CHECK(order[i].gap == Approx(expected[i].gap).margin(kRounding));
}

TEST_CASE("what cells would refer to among some views is what they refer to once the others are taken away") {
  Stream stream(0.0);
  stream.walk(30);
  const std::vector<ViewSlot> all = slots_of(Hindsight(stream.planner).thinning_order());
  CHECK(Hindsight(stream.planner).references_among(all).views == stream.atlas.snapshot().references.views);
  std::vector<ViewSlot> kept, gone;
  for (const ViewSlot slot : all) (slot % 3 == 0 ? gone : kept).push_back(slot);
  const ReferenceTable among = Hindsight(stream.planner).references_among(kept);
  const ReferenceTable fewer = Hindsight(stream.planner).references_among(kept, {}, 0.1);
  CHECK(fewer.views.size() < among.views.size());
  Pruning(stream.planner).evict(gone);
  CHECK(stream.atlas.snapshot().references.views == among.views);
  CHECK(stream.atlas.snapshot().references.offsets == among.offsets);
  Pruning(stream.planner).give_up_references(0.1);
  CHECK(stream.atlas.snapshot().references.views == fewer.views);
  CHECK_THROWS_WITH(Pruning(stream.planner).evict(gone), Catch::Contains("slot 0 holds no view"));
  CHECK_THROWS_WITH(Pruning(stream.planner).evict(std::array{ViewSlot{3000}}),
                    Catch::Contains("slot 3000 holds no view"));
}

TEST_CASE("without a bound nothing is taken away and no loss is predicted") {
  Stream stream(std::nullopt);
  stream.walk(10);
  CHECK(Pruning(stream.planner).prune().empty());
  CHECK_THROWS_AS(Pruning(stream.planner).predicted_loss(), std::logic_error);
}

TEST_CASE("bounds that break a rule are refused by name") {
  for (const double bound : {-0.1, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    CHECK_THROWS_WITH(check(options_for_room(bound)), Catch::Contains("max_loss_db is "));
  }
  PlannerOptions options = options_for_room(0.1);
  CHECK_NOTHROW(check(options));
  options.coverage.metric = CoverageOptions::Metric::paper;
  CHECK_THROWS_WITH(check(options), Catch::Contains("max_loss_db is "));
}

TEST_CASE("the predicted loss is 0 without a gap, rises with it, and allows no empty store") {
  CHECK(predicted_loss_db(0) == 0);
  double last = 0;
  for (const double gap : {0.001, 0.01, 0.1, 0.5, 0.9, 1.0}) {
    CHECK(predicted_loss_db(gap) > last);
    last = predicted_loss_db(gap);
  }
  CHECK(std::isfinite(last));
  CHECK(last > 50);
}

TEST_CASE("no store that the law was found on lost more than is predicted of its gap") {
  struct Measured {
    double gap, loss_db;
  };
  // Those of data/results/loss-law.csv that lost most for their gap, and one of an apartment of 400 photographs.
  for (const auto& [gap, loss_db] : {Measured{0.006, 0.049},
                                     {0.015, 0.087},
                                     {0.015, 0.136},
                                     {0.024, 0.243},
                                     {0.029, 0.196},
                                     {0.066, 0.420},
                                     {0.104, 0.542},
                                     {0.158, 0.893},
                                     {0.301, 1.531},
                                     {0.324, 1.798},
                                     {0.538, 3.614}}) {
    CAPTURE(gap);
    CHECK(predicted_loss_db(gap) >= loss_db);
    CHECK(predicted_loss_db(gap) < 0.15 + 2 * loss_db);  // nor is it a bound that says nothing
  }
}

}  // namespace
}  // namespace lumatlas
