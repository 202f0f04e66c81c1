// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs at the edges: black, white, without texture, of mirrors, with jumps of exposure.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <random>

#include "tests/extremes/extreme_scenes.h"
#include "tests/support/rendering_difference.h"

namespace lumatlas {
namespace {

EdgeScene plain_scene(int level) {
  EdgeScene scene = court_scene(6);
  for (EdgeView& view : scene.views) view.photograph = plain_photograph(view.camera, level);
  return scene;
}

TEST_CASE("photographs of one colour, black and white among them, lose no view and move none") {
  for (const int level : {0, 1, 90, 128, 254, 255}) {
    CAPTURE(level);
    const EdgeScene scene = plain_scene(level);
    const BuildResult result = built(scene, default_build());
    CHECK(count_of(result, Decision::outlier) == 0);
    CHECK(stored_names(result).size() >= 3);
    for (const PlannedView& view : result.planned) {
      if (view.verdict.refinement) CHECK_FALSE(view.verdict.refinement->alignment.moved);
    }
    const Rendering picture = pictured(result, novel_camera());
    CHECK(textured_share(picture) > 0.6);
    CHECK(textured_error(picture, plain_photograph(novel_camera(), level)) <= 1);
  }
}

TEST_CASE("a plain wall with the noise of a camera is no outlier either") {
  EdgeScene scene = plain_scene(128);
  std::mt19937 random(3);
  for (EdgeView& view : scene.views) {
    for (std::uint8_t& value : view.photograph.rgb) value = static_cast<std::uint8_t>(127 + random() % 3);
  }
  const BuildResult result = built(scene, default_build());
  CHECK(count_of(result, Decision::outlier) == 0);
  CHECK(textured_error(pictured(result, novel_camera()), plain_photograph(novel_camera(), 128)) < 3);
}

TEST_CASE("a lens cap and a flash among good photographs are answered for, and do not turn the others away") {
  for (const int level : {0, 128, 255}) {
    CAPTURE(level);
    EdgeScene scene = court_scene(10);
    scene.views[5].photograph = plain_photograph(scene.views[5].camera, level);
    const BuildResult result = built(scene, default_build());
    for (const PlannedView& view : result.planned) {
      if (view.name != "0005.png") CHECK(view.verdict.decision != Decision::outlier);
    }
    CHECK(stored_names(result).size() >= 4);
  }
}

TEST_CASE("exposures that jump by two stops are evened out") {
  EdgeScene scene{court(), {}};
  const EdgeScene even = court_scene(8);
  for (std::size_t view = 0; view < 8; ++view) {
    const Camera camera = court_camera((static_cast<double>(view) + 0.5) / 8);
    add_view(scene, camera);
    scene.views.back().photograph = photographed(scene.soup, camera, court_shading(), view % 2 == 0 ? 0.5 : 2);
  }
  const BuildResult result = built(scene, default_build());
  CHECK(count_of(result, Decision::outlier) == 0);
  CHECK(stored_names(result).size() >= 4);
  std::vector<double> dark, bright;  // gains
  for (std::size_t slot = 0; slot < result.snapshot.views.size(); ++slot) {
    if (!result.snapshot.views[slot]) continue;
    (std::stoi(result.snapshot.views[slot]->name) % 2 == 0 ? dark : bright).push_back(result.snapshot.gains[slot].g);
  }
  REQUIRE_FALSE(dark.empty());
  REQUIRE_FALSE(bright.empty());
  for (const double d : dark) {
    for (const double b : bright) CHECK(std::log2(d / b) == Approx(2).margin(0.35));  // some of the bright is clipped
  }
}

TEST_CASE("a mirror, which no surface colour explains, loses no view silently and shows a view from its own place") {
  // Every point shows what the direction to the camera says, and nothing else.
  const EdgeShading mirror = [](const glm::dvec3& point, const glm::dvec3& center) {
    return court_color(4.0 * glm::normalize(center - point));
  };
  EdgeScene scene{court(), {}};
  for (int view = 0; view < 8; ++view) {
    add_view(scene, court_camera((view + 0.5) / 8));
    scene.views.back().photograph = photographed(scene.soup, scene.views.back().camera, mirror);
  }
  BuildOptions options = default_build();
  (void)built(scene, options);
  options.refine = RefineMode::none;
  options.cells.size = 1;  // many pixels wide, so that each cell refers to whoever sees it
  // Or others would weigh more than the nearest where this is near the end of its picture, or on a slope.
  options.planner.validity.fade_px = 0;
  options.planner.validity.depth_edge = 1;
  const BuildResult unrefined = built(scene, options);
  const auto view = std::find_if(scene.views.begin(), scene.views.end(), [&](const EdgeView& candidate) {
    const std::vector<std::string> names = stored_names(unrefined);
    return std::find(names.begin(), names.end(), candidate.name) != names.end();
  });
  REQUIRE(view != scene.views.end());
  BlendOptions nearest;
  nearest.views = 1;
  nearest.fade_last = false;
  CHECK(textured_error(pictured(unrefined, view->camera, nearest), view->photograph) < 12);
}

}  // namespace
}  // namespace lumatlas
