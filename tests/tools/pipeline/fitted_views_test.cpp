// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/fitted_views.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/support/temporary_folder.h"
#include "tests/tools/pipeline/bounded_build.h"
#include "tests/tools/pipeline/sharp_scene.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/build_summary.h"

namespace lumatlas {
namespace {

// All views are stored, in tiles that may take a share of their bytes.
BuildOptions all_stored() {
  BuildOptions options = bounded_build(0);
  options.planner = {};
  options.planner.min_view_gain = 0;
  options.max_texel_loss_db = 0;
  options.cells.size = 0.3;
  options.least_scale = 0.25;
  return options;
}

// Where most of what a photograph shows is in others too.
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
  options.gpu_bytes =
      all.gpu_bytes.sum() - photographs + static_cast<std::uint64_t>(share * static_cast<double>(photographs));
  options.least_scale = least_scale;
  BuildResult result = build_model(scene, options);
  CHECK(result.gpu_bytes.sum() <= options.gpu_bytes);
  CHECK(result.gpu_bytes.sum() > options.gpu_bytes * 4 / 5);
  return result;
}

TEST_CASE("within a budget sharp photographs of exact poses give up parts, and blurred ones pixels") {
  const TemporaryFolder folder;
  write_changed(dense_scene(), folder.path(), blur);
  const BuildResult sharp = built_in(dense_scene(), 0.35), blurred = built_in(folder.path(), 0.35);
  CHECK(sharp.scale > blurred.scale);
  REQUIRE(sharp.fitted_loss);
  REQUIRE(blurred.fitted_loss);
  CHECK(sharp.fitted_loss->mean_db > blurred.fitted_loss->mean_db);
  const nlohmann::json told = summary(sharp, sharp.options);
  CHECK(told["texels"]["loss_db"] == sharp.fitted_loss->mean_db);
  CHECK_THAT(summary_text(told, "it"), Catch::Contains(" MB, which costs photographs "));
}

TEST_CASE("nothing is measured where all fits, where no photograph may be smaller, or where there are too few") {
  const BuildResult all = build_model(dense_scene(), all_stored());
  CHECK(all.scale == 1);
  CHECK_FALSE(all.fitted_loss);
  CHECK_FALSE(built_in(dense_scene(), 1).fitted_loss);
  const BuildResult parts = built_in(dense_scene(), 0.35, 1);
  CHECK(parts.scale == 1);
  CHECK_FALSE(parts.fitted_loss);
  CHECK(summary(parts, parts.options)["texels"]["loss_db"].is_null());
}

}  // namespace
}  // namespace lumatlas
