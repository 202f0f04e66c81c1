// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/planner.h"

#include <tbb/global_control.h>

#include <catch2/catch.hpp>
#include <glm/glm.hpp>
#include <set>

#include "mesh/base/errors.h"
#include "planner/refinement/surface_samples.h"
#include "planner/surface_distance.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

PlannerOptions options_for_room() {
  PlannerOptions options;
  options.coverage.ideal_distance = 2;
  options.coverage.max_references = 4;
  options.visibility_px = 64;
  options.refinement.alignment.pose = false;  // coverage is that of the poses as they were offered
  return options;
}

struct Planned {
  explicit Planned(std::uint32_t max_views, const PlannerOptions& planner_options = options_for_room())
      : surface(room_surface()),
        visibility(make_ray_visibility(surface->mesh)),
        atlas(surface, max_views),
        planner(atlas, *visibility, planner_options) {}
  Verdict offer(std::size_t number) {
    const Camera camera = room_camera(number);
    return planner.offer("view " + std::to_string(number), camera, pattern_photograph(camera, number));
  }
  std::shared_ptr<const Surface> surface;
  std::unique_ptr<Visibility> visibility;
  Atlas atlas;
  Planner planner;
};

TEST_CASE("the first view is kept and every cell that it sees refers to it") {
  Planned scene(3);
  const Verdict verdict = scene.offer(0);
  CHECK(verdict.decision == Decision::kept);
  REQUIRE(verdict.slot == 0u);
  CHECK(verdict.gain > 0);
  std::size_t referring = 0;
  for (CellId cell{0}; cell < scene.surface->cells.cells.size(); ++cell) {
    const std::vector<ViewSlot> slots = scene.atlas.references(cell);
    if (!slots.empty()) CHECK(slots == std::vector<ViewSlot>{0});
    referring += slots.size();
  }
  CHECK(referring == verdict.cells_seen);
}

TEST_CASE("a view that shows nothing of the mesh is rejected and nothing of it is held") {
  Planned scene(3);
  Camera away = room_camera(0);
  away.cam_from_world_rotation = glm::dmat3(1);
  away.cam_from_world_translation = {500, 500, 500};
  const Verdict verdict = scene.planner.offer("lost", away, pattern_photograph(away, 1));
  CHECK(verdict.decision == Decision::rejected);
  CHECK(verdict.cells_seen == 0);
  CHECK(scene.atlas.size() == 0);
}

TEST_CASE("a repeated view is kept no more often than a novel direction counts views") {
  Planned scene(40);
  for (std::size_t i = 0; i < 12; ++i) scene.offer(i);
  const std::uint32_t before = scene.atlas.size();
  std::size_t kept = 0;
  for (std::size_t repeat = 0; repeat < 10; ++repeat) kept += scene.offer(5).decision != Decision::rejected;
  CHECK(kept <= options_for_room().coverage.views_per_direction);
  CHECK(scene.atlas.size() == before + kept);
}

TEST_CASE(
    "the store and each cell's references stay within their bounds, and refer to stored views that see the cell") {
  const PlannerOptions options = options_for_room();
  Planned scene(5, options);
  for (std::size_t i = 0; i < 60; ++i) {
    scene.offer((7 * i) % 60);
    REQUIRE(scene.atlas.size() <= 5);
  }
  CHECK(scene.atlas.size() == 5);
  for (CellId cell{0}; cell < scene.surface->cells.cells.size(); ++cell) {
    const std::vector<ViewSlot> slots = scene.atlas.references(cell);
    CHECK(slots.size() <= options.coverage.max_references);
    CHECK(std::set<std::uint32_t>(slots.begin(), slots.end()).size() == slots.size());
    for (const ViewSlot slot : slots) CHECK(scene.atlas.view(slot) != nullptr);
  }
}

TEST_CASE("without demand, keeping a view raises the coverage by what its verdict says, and a rejected one leaves it") {
  PlannerOptions options = options_for_room();
  options.coverage.demand = false;
  Planned scene(4, options);
  for (std::size_t i = 0; i < 50; ++i) {
    const double before = scene.planner.store().summed_coverage();
    const Verdict verdict = scene.offer((13 * i) % 50);
    const double rise = scene.planner.store().summed_coverage() - before;
    if (verdict.decision == Decision::kept) CHECK(rise == Approx(verdict.gain).margin(1e-6));
    if (verdict.decision == Decision::rejected) CHECK(rise == 0);
    // Qualities are single precision.
    if (verdict.decision == Decision::replaced) CHECK(rise == Approx(verdict.gain).margin(1e-6));
  }
}

TEST_CASE("the same stream gives the same references on one thread as on many, beside another planner") {
  Planned first(6);
  Planned second(6);
  Planned other(3);
  for (std::size_t i = 0; i < 40; ++i) {
    first.offer(i);
    other.offer(3 * i);
    const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
    second.offer(i);
  }
  const Snapshot a = first.atlas.snapshot();
  const Snapshot b = second.atlas.snapshot();
  CHECK(a.references.offsets == b.references.offsets);
  CHECK(a.references.views == b.references.views);
}

TEST_CASE("a store of one view and one reference per cell works") {
  PlannerOptions options = options_for_room();
  options.coverage.max_references = 1;
  Planned scene(1, options);
  for (std::size_t i = 0; i < 20; ++i) scene.offer(i);
  CHECK(scene.atlas.size() == 1);
  CHECK(std::isfinite(scene.planner.store().summed_coverage()));
}

TEST_CASE("planner options that break a rule are refused by name") {
  PlannerOptions options = options_for_room();
  options.min_exchange_gain = -1;
  CHECK_THROWS_WITH(check(options), Catch::Contains("min_exchange_gain is -1"));
  options = options_for_room();
  options.coverage.ideal_distance = 0;
  CHECK_THROWS_WITH(check(options), Catch::Contains("ideal_distance"));
  options = options_for_room();
  options.min_view_gain = -1;
  CHECK_THROWS_WITH(check(options), Catch::Contains("min_view_gain"));
}

TEST_CASE("the median distance is found, and cameras that see nothing are reported") {
  const auto surface = room_surface();
  const auto visibility = make_ray_visibility(surface->mesh);
  std::vector<Camera> cameras;
  for (std::size_t i = 0; i < 30; ++i) cameras.push_back(room_camera(i));
  const double distance = median_surface_distance(cameras, *visibility);
  CHECK(distance > 0.5);
  CHECK(distance < 4);  // the room is 4 wide
  Camera lost = cameras[0];
  lost.cam_from_world_rotation = glm::dmat3(1);
  lost.cam_from_world_translation = {500, 500, 500};
  CHECK_THROWS_AS(median_surface_distance(std::vector<Camera>{lost}, *visibility), InputError);
}

// In a mesh of other units all cameras may stand in one point of it.
class SurfaceAtNoDistance : public Visibility {
 public:
  void trace(const Camera& camera, VisibilityBuffer& buffer) const override {
    buffer.face.assign(static_cast<std::size_t>(camera.width) * camera.height, 0);
    buffer.depth.assign(buffer.face.size(), -0.0F);
  }
};

TEST_CASE("cameras that stand on the surface that they see have no distance to it, and this is told") {
  CHECK_THROWS_WITH(median_surface_distance(std::vector<Camera>{room_camera(0)}, SurfaceAtNoDistance()),
                    Catch::StartsWith("the cameras stand on the mesh"));
}

}  // namespace
}  // namespace lumatlas
