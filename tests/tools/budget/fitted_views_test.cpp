// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/budget/fitted_views.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "tests/support/temporary_folder.h"
#include "tests/tools/pipeline/bounded_build.h"
#include "tests/tools/pipeline/sharp_scene.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/output/build_summary.h"

namespace lumatlas {
namespace {

// All views are stored, in tiles that may take a share of their bytes.
BuildOptions all_stored() {
  BuildOptions options = bounded_build(0);
  options.planner = {};
  options.planner.min_view_gain = 0;
  options.cells.size = 0.3;
  options.least_scale = 0.25;
  return options;
}

// A scene in which other photographs show most of what one shows.
const std::filesystem::path& dense_scene() {
  static const TemporaryFolder folder;
  static const bool made = (write_apartment(folder.path(), 40), true);
  REQUIRE(made);
  return folder.path();
}

BuildResult built_in(const std::filesystem::path& scene, double share, double least_scale = 0.25) {
  BuildOptions options = all_stored();
  static const BuildResult all = build_model(dense_scene(), options);
  const std::uint64_t photographs = all.gpu_bytes.photographs();
  options.bound = Bound::of_gpu(all.gpu_bytes.sum() - photographs +
                                static_cast<std::uint64_t>(share * static_cast<double>(photographs)));
  options.least_scale = least_scale;
  BuildResult result = build_model(scene, options);
  CHECK(result.gpu_bytes.sum() <= options.bound.gpu_bytes());
  CHECK(result.gpu_bytes.sum() > options.bound.gpu_bytes() * 4 / 5);
  return result;
}

TEST_CASE("within a budget sharp photographs of exact poses give up parts, and blurred ones pixels") {
  const TemporaryFolder folder;
  write_changed(dense_scene(), folder.path(), blur);
  const BuildResult sharp = built_in(dense_scene(), 0.5), blurred = built_in(folder.path(), 0.5);
  REQUIRE(sharp.fitted_loss);
  REQUIRE(blurred.fitted_loss);
  CAPTURE(sharp.scale, sharp.fitted_loss->mean_db, blurred.scale, blurred.fitted_loss->mean_db);
  CHECK(sharp.scale > blurred.scale);
  CHECK(sharp.fitted_loss->mean_db > blurred.fitted_loss->mean_db);
  const nlohmann::json told = summary(sharp, sharp.options);
  CHECK(told["texels"]["loss_db"] == sharp.fitted_loss->mean_db);
  CHECK_THAT(summary_text(told, "it"), Catch::Contains(" MB, by which photographs lose "));
}

TEST_CASE("nothing is measured where all fits, or where no photograph may be smaller") {
  const BuildResult all = build_model(dense_scene(), all_stored());
  CHECK(all.scale == 1);
  CHECK_FALSE(all.fitted_loss);
  CHECK_FALSE(built_in(dense_scene(), 1).fitted_loss);
  const BuildResult parts = built_in(dense_scene(), 0.35, 1);
  CHECK(parts.scale == 1);
  CHECK_FALSE(parts.fitted_loss);
  CHECK(summary(parts, parts.options)["texels"]["loss_db"].is_null());
}

TEST_CASE("too few photographs to measure by are downscaled until all fit") {
  const TemporaryFolder folder;
  write_apartment(folder.path(), 3);
  BuildOptions options = all_stored();
  const BuildResult all = build_model(folder.path(), options);
  options.bound = Bound::of_gpu(all.gpu_bytes.sum() - all.gpu_bytes.photographs() / 2);
  const BuildResult fitted = build_model(folder.path(), options);
  CHECK(fitted.gpu_bytes.sum() <= options.bound.gpu_bytes());
  CHECK_FALSE(fitted.fitted_loss);
  CHECK(fitted.scale < 0.95);
  CHECK(fitted.scale > 0.5);
  for (const auto& view : fitted.snapshot.views) CHECK(view);
}

// Tiles that photographs of this size are cut into.
double tiles(double width, double height, double scale) {
  constexpr double kTile = 64;
  return std::ceil(std::round(scale * width) / kTile) * std::ceil(std::round(scale * height) / kTile);
}

TEST_CASE("the largest scale with room for all tiles is found within a few steps of tiles") {
  for (const auto& [width, height] : {std::pair{640.0, 480.0}, {1920.0, 1080.0}, {4000.0, 3000.0}}) {
    for (const double share : {0.999, 0.99, 0.96, 0.9, 0.75, 0.58, 0.4, 0.2, 0.1}) {
      int asked = 0;
      const double whole = tiles(width, height, 1);
      const auto share_at = [&, w = width, h = height](double scale) {
        ++asked;
        return share * whole / tiles(w, h, scale);
      };
      const double found = largest_fitting_scale(0.25, share, share_at);
      CAPTURE(width, height, share, found);
      CHECK(asked <= 6);
      CHECK(share_at(found) >= 1);
      CHECK(share_at(found * 1.1) < 1);
    }
  }
}

TEST_CASE("where no scale has room photographs are as small as that takes fewer tiles") {
  CHECK(largest_fitting_scale(0.5, 0.1, [](double scale) { return 0.1 / (scale * scale); }) == 0.5);
  CHECK(largest_fitting_scale(0.9, 0.99, [](double) { return 0.5; }) == 1);
  CHECK(largest_fitting_scale(0.25, 0.6, [](double) { return 0.6; }) == 1);  // a tile for each photograph
}

}  // namespace
}  // namespace lumatlas
