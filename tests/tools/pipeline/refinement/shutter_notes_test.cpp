// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs that a rolling shutter read while the camera moved: the build straightens them, and what reads its model
// later straightens them alike.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <memory>
#include <string>
#include <vector>

#include "atlas/images/photograph.h"
#include "mesh/base/errors.h"
#include "mesh/base/median.h"
#include "tests/support/temporary_folder.h"
#include "tools/lab/synth/synth.h"
#include "tools/pipeline/output/save_model.h"
#include "tools/pipeline/refinement/lens_notes.h"
#include "tools/scene/lenses/undistortion.h"

namespace lumatlas {
namespace {

constexpr double kTurnPx = 5;

SynthOptions turning_options() {
  SynthOptions options;
  options.views = 24;
  options.width = 200;
  options.height = 150;
  options.samples = 4;
  options.triangles = 4000;
  return options;
}

// Another turn for each photograph.
ShutterMotion turn_of(std::size_t number, const Camera& camera) {
  const double size = kTurnPx / camera.fx, i = static_cast<double>(number);
  return {size * glm::dvec3(std::sin(2.3 * i), std::cos(1.7 * i), 0), glm::dvec3(0)};
}

// A synthetic scene whose photographs were read while the camera turned. What undoes a turn is, to first order, the
// opposite turn.
void write_turning_scene(const std::filesystem::path& folder) {
  write_synthetic_scene(turning_options(), folder);
  const SceneViews scene = read_scene_views(folder, glm::dvec3(0));
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const SceneView& view = scene.views[i];
    const ShutterMotion turn = turn_of(i, view.camera);
    const Photograph bent = undistort(load_photograph(view), view.lens, view.camera, {}, {-turn.turn, glm::dvec3(0)});
    write_image(view.image, bent);
  }
}

// Without what no test of shutters looks at.
BuildOptions shutter_build() {
  BuildOptions options;
  options.planner.refinement.trust.enabled = false;
  options.measure_deviation = false;
  options.texture_px.reset();
  return options;
}

// The median over views of the pixels by which a motion misses the true one, at most over the picture.
double miss_px(const std::vector<SceneView>& views, bool straightened) {
  std::vector<double> misses;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Camera& camera = views[i].camera;
    const ShutterMotion truth = turn_of(i, camera), found = straightened ? views[i].motion : ShutterMotion{};
    double most = 0;
    for (const double x : {0.0, 100.0, 200.0}) {
      for (const double y : {0.0, 75.0, 150.0}) {
        const glm::dvec2 at(x, y);
        most = std::max(most, glm::distance(when_read(found, camera, at), when_read(truth, camera, at)));
      }
    }
    misses.push_back(most);
  }
  return upper_median(misses);
}

TEST_CASE("photographs of a camera that turned while they were read are straightened, then and later") {
  const TemporaryFolder scene, out;
  write_turning_scene(scene.path());
  const BuildResult built = build_model(scene.path(), shutter_build());
  REQUIRE(built.shutters);
  CAPTURE(built.shutters->estimate.residual.before, built.shutters->estimate.residual.after,
          built.shutters->estimate.median_px);
  CHECK(built.shutters->applied);
  CHECK(built.shutters->median_px > 1);
  CHECK(built.shutters->estimate.residual.after < 0.9 * built.shutters->estimate.residual.before);
  CHECK(shutters_text(built.shutters).find("rolling shutter: ") == 0);

  const auto path = out / "model";
  (void)save_model(built, path, {.format = ImageFormat::png});
  SceneViews views = read_scene_views(scene.path(), built.snapshot.surface->offset);
  correct_photographs(views.views, read_model_notes(path), path);
  CAPTURE(miss_px(views.views, false), miss_px(views.views, true));
  CHECK(miss_px(views.views, true) < 0.6 * miss_px(views.views, false));
  std::size_t compared = 0;
  for (const auto& stored : built.snapshot.views) {
    if (!stored) continue;
    const auto same = std::ranges::find(views.views, stored->name, &SceneView::name);
    CHECK(same->motion != ShutterMotion{});
    CHECK(stored->photograph->whole().rgb == load_photograph(*same).rgb);
    ++compared;
  }
  CHECK(compared > 12);
}

TEST_CASE("shutters are not looked at where that is off, and photographs of a camera at rest stay as they are") {
  const TemporaryFolder turning, rest;
  write_turning_scene(turning.path());
  BuildOptions options = shutter_build();
  options.refine_shutters = false;
  CHECK_FALSE(build_model(turning.path(), options).shutters);
  options = shutter_build();
  SynthOptions disturbed = turning_options();
  disturbed.disturbances.pose_noise = 2;
  write_synthetic_scene(disturbed, rest.path());
  const BuildResult built = build_model(rest.path(), options);
  REQUIRE(built.shutters);
  CHECK(built.shutters->estimate.views > 12);
  CHECK_FALSE(built.shutters->applied);
  CHECK(built.shutters->motions.empty());
  CHECK(shutters_text(built.shutters).empty());
}

TEST_CASE("notes about shutters that are none are refused") {
  std::vector<SceneView> views(1);
  views[0].name = "a.png";
  const auto refused = [&](const char* shutters) {
    ModelNotes notes;
    notes.plan = {{"summary", {{"shutters", nlohmann::json::parse(shutters)}}}};
    try {
      correct_photographs(views, notes, "model.glb");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  CHECK(refused("null") == "accepted");
  CHECK(refused(R"({"applied": false})") == "accepted");
  CHECK(refused(R"({"applied": true, "motions": {"b.png": 3}})") == "accepted");
  CHECK(views[0].motion == ShutterMotion{});
  CHECK(refused(R"({"applied": true, "motions": {"a.png": [1, 2, 3, 4, 5, 6]}})") == "accepted");
  CHECK(views[0].motion == ShutterMotion{{1, 2, 3}, {4, 5, 6}});
  for (const char* const shutters :
       {"5", "[]", "{}", R"({"applied": 1})", R"({"applied": true})", R"({"applied": true, "motions": {"a.png": 3}})",
        R"({"applied": true, "motions": 5})"}) {
    CAPTURE(shutters);
    CHECK(refused(shutters).find("model.glb: its notes on lenses or shutters ") == 0);
  }
}

}  // namespace
}  // namespace lumatlas
