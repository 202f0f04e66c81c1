// SPDX-License-Identifier: GPL-3.0-or-later
// Streams at the edges: other orders, the same frame again and again, a camera that stands still, room for next to
// nothing. built() checks for each that every view is answered for and that what is stored is finite.
#include <catch2/catch.hpp>
#include <glm/glm.hpp>
#include <random>

#include "mesh/base/errors.h"
#include "tests/extremes/extreme_scenes.h"
#include "tests/support/rendering_difference.h"

namespace lumatlas {
namespace {

using Catch::Contains;

constexpr std::uint64_t kBytesPerView = 96 * 72 * 10;  // colour 3, depth 4, trust, validity and rim 1 each

const EdgeScene& ten_views() {
  static const EdgeScene scene = court_scene(10);
  return scene;
}

// A frame from nearly the same place as the court camera, as a tripod gives it.
Camera shaken(std::mt19937& random, double size) {
  std::normal_distribution<double> normal(0, size);
  const glm::dvec3 shift(normal(random), normal(random), normal(random));
  return camera_towards(court_camera(0.5).center() + shift, glm::dvec3(1) + shift, 64, 48, 54);
}

TEST_CASE("with room for all views, the order of the stream changes no picture") {
  BuildOptions options = plain_build();
  const BuildResult given = built(ten_views(), options);
  REQUIRE(stored_names(given).size() == 10);
  const Rendering picture = pictured(given, novel_camera());
  CHECK(textured_share(picture) > 0.7);
  CHECK(textured_error(picture, photographed(court(), novel_camera())) < 12);  // of 96x72 photographs, resampled
  for (const StreamOrder order : {StreamOrder::reversed, StreamOrder::shuffled}) {
    options.order = order;
    const BuildResult other = built(ten_views(), options);
    CHECK(stored_names(other) == stored_names(given));
    CHECK(share_different(picture, pictured(other, novel_camera()), 1) < 0.002);
    CHECK(other.summed_coverage == Approx(given.summed_coverage).epsilon(1e-6));
  }
}

TEST_CASE("in any order the defaults keep views, and show the colours of the surface") {
  for (const StreamOrder order : {StreamOrder::given, StreamOrder::reversed, StreamOrder::shuffled}) {
    BuildOptions options = default_build();
    options.order = order;
    options.max_views = 4;
    const BuildResult result = built(ten_views(), options);
    CHECK(stored_names(result).size() == 4);
    CHECK(count_of(result, Decision::outlier) == 0);
    const Rendering picture = pictured(result, novel_camera());
    CHECK(textured_share(picture) > 0.5);
    CHECK(textured_error(picture, photographed(court(), novel_camera())) < 16);
  }
}

TEST_CASE("the same photograph fifty times more does not fill the store, and changes no picture") {
  EdgeScene scene = ten_views();
  const EdgeView first = scene.views.front();
  for (int copy = 0; copy < 50; ++copy) {
    EdgeView again = first;
    again.name = "0000-" + std::to_string(copy) + ".png";  // straight after the first
    scene.views.push_back(std::move(again));
  }
  BuildOptions options = default_build();
  options.refine = RefineMode::none;
  const BuildResult once = built(ten_views(), options);
  const BuildResult often = built(scene, options);
  CHECK(stored_names(once).size() >= 5);
  CHECK(stored_names(often).size() <= stored_names(once).size() + 3);  // the best few of a direction count: demand
  const Rendering a = pictured(once, novel_camera()), b = pictured(often, novel_camera());
  CHECK(textured_share(b) == Approx(textured_share(a)).margin(0.02));
  CHECK(textured_error(b, photographed(court(), novel_camera())) <
        textured_error(a, photographed(court(), novel_camera())) + 2);
}

TEST_CASE("of two hundred frames of a camera on a tripod not a tenth are stored") {
  std::mt19937 random(11);
  EdgeScene scene{court(), {}};
  for (int frame = 0; frame < 200; ++frame) add_view(scene, shaken(random, 1e-3));
  const BuildResult result = built(scene, default_build());
  CHECK(stored_names(result).size() >= 1);
  CHECK(stored_names(result).size() < 20);  // cells are smaller than pixels: each frame sees some that no other does
  CHECK(count_of(result, Decision::outlier) == 0);
}

TEST_CASE("one reference, one view and one blended view are enough for a picture, and eight not too many") {
  const Photograph truth = photographed(court(), novel_camera());
  for (const std::uint32_t references : {1u, 16u}) {
    for (const std::uint32_t views : {1u, 2u, 10u}) {
      CAPTURE(references, views);
      BuildOptions options = default_build();
      options.planner.coverage.max_references = references;
      options.max_views = views;
      const BuildResult result = built(ten_views(), options);
      CHECK(stored_names(result).size() <= views);
      CHECK(stored_names(result).size() >= 1);
      for (const std::uint32_t blended : {1u, kMaxBlendedViews}) {
        BlendOptions blend;
        blend.views = blended;
        const Rendering picture = pictured(result, novel_camera(), blend);
        CHECK(textured_share(picture) > 0.3);
        CHECK(textured_error(picture, truth) < 16);
      }
    }
  }
}

TEST_CASE("the printed metric, too, takes one reference and one view") {
  BuildOptions options = default_build();
  const double ideal_distance = options.planner.coverage.ideal_distance;
  options.planner.coverage = CoverageOptions::printed();
  options.planner.coverage.ideal_distance = ideal_distance;
  options.planner.coverage.max_references = 1;
  options.max_views = 1;
  CHECK(stored_names(built(ten_views(), options)).size() == 1);
}

TEST_CASE("one photograph is a model; two from the same place are hardly more") {
  for (const std::size_t views : {1u, 2u}) {
    EdgeScene scene{court(), {}};
    for (std::size_t view = 0; view < views; ++view) add_view(scene, court_camera(0.5));
    const BuildResult result = built(scene, default_build());
    CHECK(stored_names(result).size() >= 1);
    const Rendering picture = pictured(result, court_camera(0.5));
    CHECK(textured_share(picture) > 0.6);
    CHECK(textured_error(picture, scene.views[0].photograph) < 2);  // rounding, and whatever resampling there is
  }
}

TEST_CASE("a budget of exactly one view holds one, of a byte less is refused, and all choosers keep to it") {
  BuildOptions options = plain_build();
  options.tiles = kWholeViews;
  options.max_views.reset();
  for (const ViewChoice choice : {ViewChoice::online, ViewChoice::offline, ViewChoice::uniform, ViewChoice::random}) {
    options.choice = choice;
    options.planner.max_bytes = kBytesPerView;
    CHECK(stored_names(built(ten_views(), options)).size() == 1);
    options.planner.max_bytes = kBytesPerView - 1;
    CHECK_THAT(refused(ten_views(), options), Contains("more than the budget of " + std::to_string(kBytesPerView - 1)));
  }
}

TEST_CASE("a budget of one tile shows one tile, and tiles larger than the photographs show all of them") {
  BuildOptions options = plain_build();
  options.tiles = {16, 2, 0};
  options.bound = Bound::of_array(place_bytes(options.tiles));
  const BuildResult one = built(ten_views(), options);
  CHECK(one.snapshot.tiles.resident_tiles() == 1);
  CHECK(textured_share(pictured(one, novel_camera())) > 0);
  options.tiles = {1024, 8, 0};
  options.bound = {};
  const BuildResult large = built(ten_views(), options);
  options.tiles = kWholeViews;
  const BuildResult whole = built(ten_views(), options);
  CHECK(share_different(pictured(large, novel_camera()), pictured(whole, novel_camera()), 2) < 0.02);
}

TEST_CASE("a protocol that leaves nothing to build from, or nothing to score, says so") {
  const EdgeScene one = court_scene(1);
  BuildOptions options = default_build();
  options.hold_out = HoldOut{2, 1};
  CHECK_THAT(refused(one, options), Contains("none of its 1 views is left to build from: check --hold and --block"));
  options.hold_out = HoldOut{2, 1000};
  CHECK_THAT(refused(ten_views(), options), Contains("none of its 10 views is left to build from"));
  SceneViews views{"scene", {}};
  views.views.resize(10);
  CHECK_THROWS_WITH(split_to_score(views, HoldOut{2, 99}), Contains("scores none of its 10 views"));
  views.views.clear();
  CHECK_THROWS_WITH(split_to_score(views, HoldOut{2, 1}), Contains("scores none of its 0 views"));
}

TEST_CASE("a scene without photographs is one sentence") {
  EdgeScene scene = court_scene(1);
  scene.views.clear();
  CHECK_FALSE(refused(scene, default_build()).empty());
}

}  // namespace
}  // namespace lumatlas
