// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/budget/held_out_loss.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "planner/coverage/predicted_loss.h"
#include "planner/pruning/hindsight.h"
#include "planner/tile_choice.h"
#include "tests/support/scenes/small_scenes.h"
#include "tools/budget/thinned_views.h"
#include "tools/score/measures/scores.h"

namespace lumatlas {
namespace {

PlannerOptions planner_options() {
  PlannerOptions options;
  options.coverage = parsimony_coverage({});
  options.coverage.ideal_distance = 2;
  options.coverage.max_references = 64;
  options.visibility_px = 64;
  options.min_view_gain = 0;
  options.max_loss_db = 0;
  options.refinement.alignment.pose = options.refinement.alignment.exposure = false;
  return options;
}

std::uint8_t colour_of(double x) {
  return static_cast<std::uint8_t>(std::lround(127.5 + 100 * std::sin(x)));
}

// Of a room whose colours depend on the place alone, so that photographs agree, but for `haze`, by which the photograph
// is brighter.
Photograph photograph_of(const Camera& camera, const Visibility& visibility, int haze) {
  Photograph photograph = pattern_photograph(camera, 1);
  const VisibilityBuffer seen = visibility.trace(camera);
  for (std::size_t pixel = 0; pixel < seen.depth.size(); ++pixel) {
    if (!std::isfinite(seen.depth[pixel])) continue;
    const auto x = static_cast<double>(pixel % camera.width) + 0.5, y = static_cast<double>(pixel / camera.width) + 0.5;
    const glm::dvec3 point = camera.center() + double{seen.depth[pixel]} * camera.ray({x, y});
    for (int channel = 0; channel < 3; ++channel) {
      const int value = colour_of(4 * point[channel] + 3 * point[(channel + 1) % 3]) + haze;
      photograph.rgb[3 * pixel + static_cast<std::size_t>(channel)] =
          static_cast<std::uint8_t>(std::clamp(value, 0, 255));
    }
  }
  return photograph;
}

// Each place of a walk round the room has two cameras side by side.
Camera camera_of_pair(std::size_t number) {
  Camera camera = room_camera(number / 2);
  if (number % 2 == 1) camera.cam_from_world_translation.x += 0.1;
  return camera;
}

struct Store {
  // `haze` of every other photograph.
  explicit Store(std::size_t views, int haze = 0, const TileOptions& layout = kWholeViews)
      : surface(room_surface()),
        visibility(make_ray_visibility(surface->mesh)),
        atlas(surface, 100, layout),
        planner(atlas, *visibility, planner_options()) {
    for (std::size_t i = 0; i < views; ++i) {
      const Camera camera = camera_of_pair(i);
      const bool hazy = i % 2 == 1;
      planner.offer("view " + std::to_string(i), camera, photograph_of(camera, *visibility, hazy ? haze : 0));
    }
    REQUIRE(planner.store().stored_views() == views);
  }

  std::shared_ptr<const Surface> surface;
  std::unique_ptr<Visibility> visibility;
  Atlas atlas;
  Planner planner;
  BuildCallback nobody;
  BuildStage stage{nobody, "measuring", 0};
};

TEST_CASE("a store loses nothing against itself, more the more is taken away, and most when nothing is left") {
  Store store(32);
  HeldOutLoss measured(store.planner, store.atlas, store.stage);
  REQUIRE(measured.can_tell());
  CHECK(measured.now({}).mean_db == Approx(0).margin(1e-3));  // its neighbouring cells may be joined or not
  const std::vector<ThinningStep> order = Hindsight(store.planner).thinning_order();
  double last = 0.001;
  for (const std::size_t gone : {16, 26, 31}) {
    const MeasuredLoss loss = measured.now({order[gone - 1].gap, 0});
    CAPTURE(gone, loss.mean_db, loss.error_db);
    CHECK(loss.mean_db > last);
    CHECK(loss.error_db > 0);
    last = loss.mean_db;
  }
  CHECK(measured.now({1, 0}).mean_db > last);
  CHECK(store.planner.store().stored_views() == 32);
}

TEST_CASE("what the pictures of a store lose is what they lose in its folds, drawn one by one") {
  // Of eight views each is a fold. Its photograph is compared with a picture drawn from the other seven, and then from
  // those of them that are left, by hand.
  Store store(8, 20);
  HeldOutLoss measured(store.planner, store.atlas, store.stage);
  const double gap = Hindsight(store.planner).thinning_order()[3].gap;
  const MeasuredLoss loss = measured.now({gap, 0});

  EglContext context;
  Snapshot snapshot = store.atlas.snapshot();
  const auto draw = [&](std::vector<ViewSlot> slots, const std::array<ViewSlot, 1>& absent, const Camera& camera) {
    std::sort(slots.begin(), slots.end());
    snapshot.references = Hindsight(store.planner).references_among(slots, absent);
    Renderer renderer;
    renderer.load(snapshot);
    return renderer.render(camera, {});
  };
  double sum = 0;
  for (ViewSlot out{0}; out < 8; ++out) {
    std::vector<ViewSlot> others, left;
    for (const ThinningStep& step : Hindsight(store.planner).thinning_order(std::array{out})) {
      others.push_back(step.slot);
      if (step.gap > gap) left.push_back(step.slot);
    }
    const StoredView& view = *snapshot.views[out];
    const Rendering whole = draw(others, {out}, view.camera), less = draw(left, {out}, view.camera);
    double before = 0, after = 0;
    for (std::size_t value = 0; value < 3 * view.photograph->pixels(); ++value) {
      if (whole.state[value / 3] != PixelState::textured) continue;
      before += std::pow(int{whole.picture.rgb[value]} - int{view.photograph->color(value / 3).at(value % 3)}, 2);
      after += std::pow(int{less.picture.rgb[value]} - int{view.photograph->color(value / 3).at(value % 3)}, 2);
    }
    sum += 10 * std::log10(after / before);
  }
  CHECK(loss.mean_db == Approx(sum / 8).margin(0.01));
  CHECK(std::abs(loss.mean_db) > 0.1);
}

// A fold's store, in such a share of the whole store's tiles.
Snapshot with_tiles(const Store& store, ViewSlot absent, double share) {
  Snapshot snapshot = store.atlas.snapshot();
  TileTable& tiles = snapshot.tiles;
  const double wanted = share * tiles.resident_tiles();
  const auto begin = tiles.places.begin();
  std::fill(begin + tiles.first_tile[absent], begin + tiles.first_tile[absent + 1], TilePlace::none);
  leave_out_views_without_tiles(snapshot);
  std::vector<ViewSlot> others;
  std::vector<SharedShownCells> shown;
  for (ViewSlot slot{0}; slot < snapshot.views.size(); ++slot) {
    if (snapshot.views[slot]) others.push_back(slot);
    shown.push_back(snapshot.views[slot] ? store.atlas.shown(slot) : std::make_shared<std::vector<ShownCell>>());
  }
  snapshot.references = Hindsight(store.planner).references_among(others, std::array{absent});
  if (share == 1) return snapshot;
  const auto kept = static_cast<std::size_t>(std::min(wanted, (1 + share) / 2 * tiles.resident_tiles()));
  const TileChoice choice = choose_tiles({*snapshot.surface, snapshot.views, shown, snapshot.references, kept, {}});
  std::vector<TilePlace> slots(tiles.places.size(), TilePlace::none);
  for (const ViewTile& tile : choice.tiles) {
    const std::size_t place = tiles.first_tile[tile.view] + tile.tile;
    slots[place] = tiles.places[place];
  }
  tiles.places = slots;
  snapshot.references = choice.references;
  leave_out_views_without_tiles(snapshot);
  return snapshot;
}

std::vector<std::uint8_t> textured_pixels(const Rendering& drawn) {
  std::vector<std::uint8_t> textured;
  for (const PixelState state : drawn.state) textured.push_back(state == PixelState::textured ? 1 : 0);
  return textured;
}

TEST_CASE("each fold chooses its own tiles, and loses more the fewer they are") {
  constexpr std::array kShares{0.9, 0.5, 0.05};  // a fold has an eighth of the tiles less
  Store store(8, 20, {8, 2, 0});
  std::vector<MeasuredLoss> losses;
  {
    HeldOutLoss measured(store.planner, store.atlas, store.stage);
    for (const double share : kShares) losses.push_back(measured.now({{}, 0, share}));
    CHECK(measured.now({{}, 0, 1}).mean_db == Approx(0).margin(1e-3));
  }
  EglContext context;
  const auto draw = [&](ViewSlot absent, double share, const Camera& camera) {
    Renderer renderer({.join_cells = false});
    renderer.load(with_tiles(store, absent, share));
    BlendOptions options;
    options.supersample = 1;
    return renderer.render(camera, options);
  };
  double last = 1e-3;
  for (std::size_t i = 0; i < kShares.size(); ++i) {
    double sum = 0, ssim_sum = 0;
    for (ViewSlot out{0}; out < 8; ++out) {
      const StoredView& view = *store.atlas.view(ViewSlot(out));
      const Rendering whole = draw(out, 1, view.camera), less = draw(out, kShares[i], view.camera);
      const std::vector<std::uint8_t> counts = textured_pixels(whole);
      sum +=
          psnr(whole.picture, view.photograph->whole(), counts) - psnr(less.picture, view.photograph->whole(), counts);
      ssim_sum +=
          ssim(whole.picture, view.photograph->whole(), counts) - ssim(less.picture, view.photograph->whole(), counts);
    }
    CAPTURE(kShares[i], losses[i].mean_db);
    CHECK(losses[i].mean_db == Approx(sum / 8).margin(0.01));
    CHECK(losses[i].ssim == Approx(ssim_sum / 8).margin(1e-4));
    CHECK(losses[i].ssim > 0);
    CHECK(losses[i].mean_db > last);
    last = losses[i].mean_db;
  }
}

TEST_CASE("whole views have no tiles to give up") {
  Store store(8);
  HeldOutLoss measured(store.planner, store.atlas, store.stage);
  CHECK_THROWS_AS(measured.now({{}, 0, 0.5}), std::logic_error);
}

TEST_CASE("with a bound the loss is on the same side of it as without") {
  Store store(64);
  HeldOutLoss measured(store.planner, store.atlas, store.stage);
  const double gap = Hindsight(store.planner).thinning_order()[48].gap;
  const MeasuredLoss exact = measured.now({gap, 0});
  const double loss = exact.mean_db;
  for (const double bound : {0.0, 0.5 * loss, 2 * loss, 20.0}) {
    CHECK((measured.now({gap, 0}, bound).mean_db > bound) == (loss > bound));
  }
  const MeasuredLoss within = measured.now({gap, 0}, 4 * loss);
  CHECK(within.mean_db != loss);  // of fewer pictures
  CHECK(exact.ssim != 0);
  CHECK(within.ssim == 0);
}

TEST_CASE("too few photographs say nothing about loss") {
  for (const std::size_t views : {0, 1, 3}) {
    Store store(views);
    HeldOutLoss measured(store.planner, store.atlas, store.stage);
    CHECK_FALSE(measured.can_tell());
    CHECK_THROWS_AS(measured.now({}), std::logic_error);
  }
  Store four(4);
  CHECK(HeldOutLoss(four.planner, four.atlas, four.stage).can_tell());
}

TEST_CASE("as many views are taken away as pictures allow") {
  std::uint32_t last = 33;
  for (const double bound : {0.0, 3.0, 60.0}) {
    Store store(32);
    HeldOutLoss measured(store.planner, store.atlas, store.stage);
    const std::vector<ThinningStep> order = Hindsight(store.planner).thinning_order();
    const ThinnedViews thinned = thin_views_within(bound, 0, store.planner, measured);
    const std::size_t gone = thinned.taken_away.size();
    CAPTURE(bound, gone, thinned.loss.mean_db);
    CHECK(store.planner.store().stored_views() + gone == 32);
    CHECK(store.planner.store().stored_views() < last);
    CHECK(thinned.loss.at_most_db() <= bound + 1e-3);
    for (std::size_t i = 0; i < gone; ++i) CHECK(thinned.taken_away[i] == "view " + std::to_string(order[i].slot));
    last = store.planner.store().stored_views();
  }
  CHECK(last == 1);
}

TEST_CASE("where photographs contradict each other, fewer views are no worse and coverage does not hold them") {
  Store agreeing(32), hazy(32, 100);
  HeldOutLoss of_agreeing(agreeing.planner, agreeing.atlas, agreeing.stage);
  HeldOutLoss of_hazy(hazy.planner, hazy.atlas, hazy.stage);
  const std::size_t gone = thin_views_within(0.5, 0, agreeing.planner, of_agreeing).taken_away.size();
  CHECK(thin_views_within(0.5, 0, hazy.planner, of_hazy).taken_away.size() > gone);
}

}  // namespace
}  // namespace lumatlas
