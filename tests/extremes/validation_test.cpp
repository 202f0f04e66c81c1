// SPDX-License-Identifier: GPL-3.0-or-later
// Scores where there is next to nothing to score: views of nothing, of one pixel, of one colour.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "mesh/base/errors.h"
#include "planner/refinement/photometry.h"
#include "tests/extremes/extreme_scenes.h"
#include "tests/support/gl_test_context.h"
#include "tools/score/report/report.h"
#include "tools/score/validation.h"

namespace lumatlas {
namespace {

Camera looking_away() {
  const Camera camera = court_camera(0.5);
  return camera_towards(camera.center(), camera.center() - camera.viewing_direction(), 40, 30, 33);
}

// Builds from every second view and scores the others: those with an even number.
Report validated(const EdgeScene& scene, const EglContext& context) {
  const TemporaryFolder folder, report;
  write_scene(scene, folder.path());
  BuildOptions build = default_build();
  build.hold_out = HoldOut{2, 1};
  const BuildResult result = build_model(folder.path(), build);
  ValidationOptions options;
  options.protocol = *build.hold_out;
  options.quiet = true;
  options.unbounded = true;
  return validate_model(result.snapshot, read_scene_views(folder.path(), result.snapshot.surface->offset), context,
                        options, report.path());
}

TEST_CASE("held-out views of nothing and of a single pixel leave the means finite, and are told apart") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  EdgeScene scene = court_scene(7);
  scene.views[2].camera = looking_away();
  scene.views[2].photograph = photographed(scene.soup, scene.views[2].camera);
  scene.views[4].camera = court_camera(0.6).scaled_to(1, 1);
  scene.views[4].photograph = photographed(scene.soup, scene.views[4].camera);
  const Report report = validated(scene, *context);
  REQUIRE(report.views.size() == 4);
  const std::vector<MethodScores> means = method_means(report);
  REQUIRE(means.size() == 3);
  for (std::size_t method = 0; method < means.size(); ++method) {
    CAPTURE(report.methods[method].name);
    CHECK(report.views[1].renderings[method].scores.mesh.pixels == 0);
    CHECK(report.views[2].renderings[method].scores.mesh.pixels == 1);
    CHECK(means[method].mesh.views == 3);
    CHECK(std::isfinite(means[method].mesh.raw.psnr));
    CHECK(std::isfinite(means[method].mesh.raw.ssim));
    CHECK(std::isfinite(means[method].mesh.fitted.psnr));
    REQUIRE(means[method].mesh.aligned);
    CHECK(std::isfinite(means[method].mesh.aligned->psnr));
    CHECK(std::isfinite(means[method].mesh.textured));
  }
}

TEST_CASE("methods whose poses differ are compared on the same pixels, and the frame counts what shows nothing") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  EdgeScene scene = court_scene(7);
  const Camera taken_at = scene.views[2].camera;
  scene.views[2].camera = moved(taken_at, glm::dvec3(0.01, -0.02, 0.005), glm::dvec3(0.02, 0.01, 0));
  const Report report = validated(scene, *context);
  for (const ReportView& view : report.views) {
    CAPTURE(view.name);
    for (const ReportRendering& rendering : view.renderings) {
      CHECK(rendering.scores.mesh.aligned_pixels == view.renderings[0].scores.mesh.aligned_pixels);
      CHECK(rendering.scores.mesh.aligned_pixels > 0);
      CHECK(rendering.scores.mesh.aligned_pixels <= rendering.scores.mesh.pixels);
      CHECK(rendering.scores.frame.pixels == std::size_t{view.width} * view.height);
      CHECK(rendering.scores.frame.textured <= rendering.scores.mesh.textured);
      REQUIRE(rendering.scores.frame.aligned);
      CHECK(rendering.scores.frame.aligned_pixels == rendering.scores.frame.pixels);
    }
  }
}

TEST_CASE("black and white photographs are scored without a division by zero") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  for (const int level : {0, 255}) {
    EdgeScene scene = court_scene(4);
    for (EdgeView& view : scene.views) view.photograph = plain_photograph(view.camera, level);
    for (const MethodScores& mean : method_means(validated(scene, *context))) {
      for (const MeanScores& region : {mean.frame, mean.mesh}) {
        CHECK_FALSE(std::isnan(region.raw.psnr));
        CHECK_FALSE(std::isnan(region.fitted.psnr));
        CHECK(std::isfinite(region.raw.ssim));
      }
    }
  }
}

TEST_CASE("where no held-out view sees the mesh there is no mean over it, one over frames, and no crash") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  EdgeScene scene = court_scene(4);
  for (const std::size_t held : {0u, 2u}) {
    scene.views[held].camera = looking_away();
    scene.views[held].photograph = plain_photograph(scene.views[held].camera, 90);
  }
  const Report report = validated(scene, *context);
  for (const MethodScores& mean : method_means(report)) {
    CHECK(mean.mesh.views == 0);
    CHECK(std::isnan(mean.mesh.raw.psnr));
    CHECK(mean.frame.views == 2);
    CHECK(std::isfinite(mean.frame.raw.psnr));
  }
  CHECK(report_json(report)["methods"]["store"]["raw"]["psnr"].is_null());
}

}  // namespace
}  // namespace lumatlas
