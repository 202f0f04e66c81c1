// SPDX-License-Identifier: GPL-3.0-or-later
// A build is the same to the byte on any number of threads and with any memory: what it plans, refines, masks, polishes
// and writes.
#include <tbb/global_control.h>

#include <catch2/catch.hpp>
#include <sstream>
#include <string>

#include "atlas/model/model_file.h"
#include "planner/coverage/predicted_loss.h"
#include "tests/support/temporary_folder.h"
#include "tools/lab/synth/synth.h"
#include "tools/pipeline/build_model.h"

namespace lumatlas {
namespace {

// Poses, exposures and passers-by that give refinement and masks something to do.
SynthOptions disturbed() {
  SynthOptions options;
  options.views = 14;
  options.width = 96;
  options.height = 72;
  options.samples = 2;
  options.triangles = 3000;
  options.disturbances.pose_noise = 3;
  options.disturbances.exposure_noise = 0.5;
  options.disturbances.passers_by = 0.2;
  return options;
}

const std::filesystem::path& disturbed_scene() {
  static const TemporaryFolder folder;
  static const bool made = [] {
    write_synthetic_scene(disturbed(), folder.path());
    return true;
  }();
  REQUIRE(made);
  return folder.path();
}

struct Built {
  BuildResult result;
  std::string bytes;
};

Built build_on(std::size_t threads, const std::filesystem::path& scene, const BuildOptions& options) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  Built built{build_model(scene, options), {}};
  std::ostringstream file;
  REQUIRE(built.result.texture);
  write_glb(file, built.result.snapshot, options.planner.validity, {.texture = &built.result.texture->texture});
  built.bytes = file.str();
  return built;
}

void check_same_on_any_threads(const std::filesystem::path& scene, const BuildOptions& options) {
  const Built one = build_on(1, scene, options);
  REQUIRE_FALSE(one.result.polish.empty());
  REQUIRE(one.result.polish.front().views > 4);
  REQUIRE_FALSE(one.result.lenses.empty());
  REQUIRE(one.result.poses);
  CHECK(one.result.poses->improves());
  for (const std::size_t threads : {2u, 8u}) {
    CAPTURE(threads);
    const Built many = build_on(threads, scene, options);
    CHECK((many.bytes == one.bytes));
    REQUIRE(many.result.lenses.size() == one.result.lenses.size());
    CHECK(many.result.lenses[0].estimate.correction == one.result.lenses[0].estimate.correction);
    CHECK(many.result.lenses[0].estimate.deviation == one.result.lenses[0].estimate.deviation);
    REQUIRE(many.result.polish.size() == one.result.polish.size());
    CHECK(many.result.polish.back().residual_after == one.result.polish.back().residual_after);
    REQUIRE(many.result.poses);
    CHECK(many.result.poses->residual_after == one.result.poses->residual_after);
    CHECK(many.result.summed_coverage == one.result.summed_coverage);
    CHECK(many.result.revisited == one.result.revisited);
  }
}

TEST_CASE("a build with joint refinement and lenses writes the same bytes on 1, 2 and 8 threads") {
  BuildOptions options;
  options.max_views = 10;  // fewer than are offered, so that views take others' places
  check_same_on_any_threads(disturbed_scene(), options);
}

TEST_CASE("a build with a bound on the loss writes the same bytes on 1, 2 and 8 threads") {
  BuildOptions options;
  options.planner.coverage = parsimony_coverage(options.planner.coverage);
  options.planner.max_loss_db = 0.5;
  options.max_views.reset();
  check_same_on_any_threads(disturbed_scene(), options);
}

TEST_CASE("a build whose photographs and masks lie in scratch files writes the same bytes") {
  const TemporaryFolder scene, scratch;
  SynthOptions larger = disturbed();
  larger.views = 6;
  larger.width = 320;
  larger.height = 240;
  write_synthetic_scene(larger, scene.path());
  BuildOptions options;
  options.memory.scratch_folder = scratch.path();
  const Built in_memory = build_on(2, scene.path(), options);
  options.memory.bytes = 0;
  const Built in_files = build_on(2, scene.path(), options);
  CHECK(in_memory.result.scratch_bytes == 0);
  CHECK(in_files.result.scratch_bytes >= std::uint64_t{6} * 320 * 240 * (3 + 4 + 1));  // colour, depth, validity
  CHECK((in_files.bytes == in_memory.bytes));
}

}  // namespace
}  // namespace lumatlas
