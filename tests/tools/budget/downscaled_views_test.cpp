// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/budget/downscaled_views.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <stdexcept>
#include <string>

#include "atlas/model/model_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/pipeline/bounded_build.h"
#include "tests/tools/pipeline/sharp_scene.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/output/build_summary.h"
#include "tools/pipeline/output/save_model.h"

namespace lumatlas {
namespace {

// All views are stored, and then given up or downscaled within the bound.
BuildOptions within(double max_texel_loss_db) {
  BuildOptions options = bounded_build(max_texel_loss_db);
  options.cells.size = 0.3;
  return options;
}

TEST_CASE("photographs are downscaled as far as a bound on the measured loss allows") {
  const BuildResult full = build_model(sharp_scene(), within(0));
  CHECK(full.scale == 1);
  double last = 1;
  for (const double bound : {2.0, 10.0}) {
    const BuildResult result = build_model(sharp_scene(), within(bound));
    CAPTURE(bound, result.scale, result.texel_loss_db);
    CHECK(result.texel_loss_db <= bound);
    CHECK(result.scale < last);
    last = result.scale;
    for (std::size_t slot = 0; slot < full.snapshot.views.size(); ++slot) {
      if (!result.snapshot.views[slot]) continue;  // taken away
      const Camera& before = full.snapshot.views[slot]->camera;
      CHECK(result.snapshot.views[slot]->camera.width == std::lround(result.scale * before.width));
    }
    const std::size_t stored = full.snapshot.views.size() - result.parsimony->taken_away.size();
    CHECK(result.stored_bytes == stored * stored_bytes(full.snapshot.views[0]->camera));  // as they came
    const nlohmann::json parsimony = summary(result, result.options)["parsimony"];
    CHECK(parsimony["bound_db"] == bound);
    CHECK(parsimony["texel_loss_db"] == result.texel_loss_db);
    CHECK(parsimony["predicted_loss_db"] == result.parsimony->measured->mean_db);
    CHECK(parsimony["predicted_loss_db"] <= bound);
    CHECK_THAT(parsimony_text(parsimony),
               Catch::Contains(" measured, ") && Catch::Contains(" by coarser texels) of at "));
    CHECK_THAT(summary_text(summary(result, result.options), "it"), Catch::Contains(" % of their sides\n"));
  }
  CHECK(last == Approx(0.5));
}

TEST_CASE("texels are compressed if the bound on the measured loss allows it, and then downscaled") {
  for (const double bound : {0.001, 4.0}) {
    BuildOptions options = within(bound);
    options.least_scale = 1;
    const BuildResult plain = build_model(sharp_scene(), options);
    options.tight_tiles = TileOptions{8, 4, 0, TexelFormat::bc7};
    const BuildResult result = build_model(sharp_scene(), options);
    CAPTURE(bound);
    const bool compressed = bound > 1;
    CHECK((result.snapshot.tiles.options.texels == TexelFormat::bc7) == compressed);
    CHECK(result.options.tiles.gutter_px == (compressed ? 4 : 2));
    CHECK(result.parsimony->loss_db <= bound);
    CHECK(result.scale == 1);
    CHECK((result.texel_loss_db != 0) == compressed);
    CHECK((result.snapshot.tiles.places == plain.snapshot.tiles.places) == !compressed);
    const nlohmann::json told = summary(result, result.options);
    CHECK(told["texels"]["format"] == (compressed ? "bc7" : "rgb8"));
    CHECK(told["parsimony"]["gpu_bytes"]["stored"] == result.gpu_bytes.sum());
    const auto per_tile = [](const BuildResult& built) {
      return built.gpu_bytes.photographs() / built.snapshot.tiles.resident_tiles();
    };
    CHECK((2 * per_tile(result) < per_tile(plain)) == compressed);
    options.least_scale = 0.5;
    CHECK((build_model(sharp_scene(), options).scale < 1) == compressed);
  }
}

TEST_CASE("blurred photographs are downscaled further within the same bound") {
  const TemporaryFolder folder;
  write_changed(sharp_scene(), folder.path(), blur);
  CHECK(build_model(folder.path(), within(1)).scale < build_model(sharp_scene(), within(1)).scale);
}

TEST_CASE("a photograph is never predicted by itself") {
  // If no two photographs share their noise, lower resolution makes a better guess; each by itself would be exact.
  const TemporaryFolder folder;
  std::mt19937 random(7);
  write_changed(sharp_scene(), folder.path(), [&](Photograph& photograph) {
    for (std::uint8_t& value : photograph.rgb) value = static_cast<std::uint8_t>(random() % 256);
  });
  const BuildResult result = build_model(folder.path(), within(0.01));
  CHECK(result.scale == Approx(0.5));
  CHECK(result.texel_loss_db < 0);
}

TEST_CASE("where any loss is too much, photographs are as if downscaling had not been tried") {
  const BuildResult full = build_model(sharp_scene(), within(0)), tried = build_model(sharp_scene(), within(1e-6));
  REQUIRE(tried.scale == 1);
  CHECK(tried.texel_loss_db == 0);
  std::size_t compared = 0;
  for (std::size_t slot = 0; slot < full.snapshot.views.size(); ++slot) {
    if (!tried.snapshot.views[slot]) continue;  // nobody missed it
    ++compared;
    const StoredView &before = *full.snapshot.views[slot], &after = *tried.snapshot.views[slot];
    CHECK(after.photograph->whole().rgb == before.photograph->whole().rgb);
    CHECK(after.mask->depth == before.mask->depth);
    CHECK(after.mask->validity == before.mask->validity);
  }
  CHECK(compared == 16 - tried.parsimony->taken_away.size());
  CHECK(compared > 8);
}

TEST_CASE("what is masked beside depth edges is never narrower on the surface, and the model remembers it") {
  ValidityOptions validity;
  validity.edge_radius_px = 2;
  validity.fade_px = 3;
  CHECK(validity_at_scale(validity, 1).edge_radius_px == 2);
  CHECK(validity_at_scale(validity, 0.55).edge_radius_px == 2);
  CHECK(validity_at_scale(validity, 0.5).edge_radius_px == 1);
  CHECK(validity_at_scale(validity, 0.5).fade_px == 2);
  validity.edge_radius_px = 0;
  CHECK(validity_at_scale(validity, 0.5).edge_radius_px == 0);
  CHECK_THROWS_AS(validity_at_scale(validity, 0), std::invalid_argument);

  const BuildResult half = build_model(sharp_scene(), within(10));
  const TemporaryFolder folder;
  (void)save_model(half, folder / "model");
  const Model read = read_model(folder / "model");
  CHECK(read.validity.edge_radius_px == 1);
  const auto by_name = [](const Snapshot& snapshot) {
    std::map<std::string, std::shared_ptr<const StoredView>> views;
    for (const auto& view : snapshot.views) {
      if (view) views[view->name] = view;
    }
    return views;
  };
  const auto written = by_name(half.snapshot), found = by_name(read.snapshot);
  REQUIRE(written.size() == found.size());
  REQUIRE_FALSE(written.empty());
  for (const auto& [name, view] : written) CHECK(found.at(name)->mask->validity == view->mask->validity);
}

TEST_CASE("bounds on the loss by resolution are checked") {
  const auto complaint = [](double bound, bool with_loss) {
    BuildOptions options = within(bound);
    if (!with_loss) options.planner.max_loss_db.reset();
    return [options] { (void)build_model("/nowhere", options); };
  };
  for (const double bound : {-0.1, std::numeric_limits<double>::quiet_NaN()}) {
    CHECK_THROWS_WITH(complaint(bound, true)(), Catch::Contains("texel_loss_db is "));
  }
  CHECK_THROWS_WITH(complaint(0.1, false)(), Catch::Contains("planner.max_loss_db must be given too"));
}

}  // namespace
}  // namespace lumatlas
