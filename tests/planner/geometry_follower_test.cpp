// SPDX-License-Identifier: GPL-3.0-or-later
// Geometry and poses change while the stream runs: GeometryFollower.
#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "mesh/cells/cell_growth.h"
#include "planner/cell_pictures.h"
#include "planner/geometry_follower.h"
#include "planner/planner.h"
#include "planner/pruning/hindsight.h"
#include "planner/pruning/pruning.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

constexpr std::uint32_t kMostViews = 16;

PlannerOptions options_for_update(bool refine, bool demand) {
  PlannerOptions options;
  options.coverage.demand = demand;
  options.coverage.ideal_distance = 2;
  options.coverage.max_references = kMostViews;  // every view has a place, whatever the order
  options.visibility_px = 64;
  options.refinement.alignment.pose = false;
  options.refinement.alignment.exposure = refine;
  options.refinement.trust.enabled = refine;
  return options;
}

// The mesh with a free-standing panel, 0.8 wide and high, in the plane x = `x`.
Mesh with_panel(Mesh mesh, float x) {
  constexpr std::uint32_t kSteps = 8;
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const bool colored = !mesh.colors.empty();
  for (std::uint32_t row = 0; row <= kSteps; ++row) {
    for (std::uint32_t column = 0; column <= kSteps; ++column) {
      mesh.positions.emplace_back(x, -0.4f + 0.1f * static_cast<float>(column), 0.8f + 0.1f * static_cast<float>(row));
      if (colored) mesh.colors.emplace_back(128);
    }
  }
  for (std::uint32_t row = 0; row < kSteps; ++row) {
    for (std::uint32_t column = 0; column < kSteps; ++column) {
      const std::uint32_t corner = first + row * (kSteps + 1) + column;
      mesh.faces.emplace_back(corner, corner + 1, corner + kSteps + 2);
      mesh.faces.emplace_back(corner, corner + kSteps + 2, corner + kSteps + 1);
    }
  }
  return mesh;
}

struct Grown {
  std::shared_ptr<const Surface> surface;
  CellGrowth growth;
};

Grown grown(const Surface& before, Mesh mesh, std::span<const FaceId> previous_face) {
  CellOptions options;
  options.size = before.cells.size;
  CellGrowth growth = grow_cells(before.mesh, before.cells, mesh, previous_face, options);
  auto surface = std::make_shared<Surface>(Surface{std::move(mesh), growth.cells, before.offset});
  return {std::move(surface), std::move(growth)};
}

Grown grown(const Surface& before, Mesh mesh) {
  const std::vector<FaceId> previous = match_faces(before.mesh, mesh);
  return grown(before, std::move(mesh), previous);
}

struct PlannedSurface {
  PlannedSurface(std::shared_ptr<const Surface> scene, bool refine, bool demand = true)
      : surface(std::move(scene)),
        visibility(make_ray_visibility(surface->mesh)),
        atlas(surface, kMostViews),
        planner(atlas, *visibility, options_for_update(refine, demand)) {}

  void keep(std::size_t number) {
    const Camera camera = room_camera(number);
    planner.force_store("view " + std::to_string(number), camera, [&] { return pattern_photograph(camera, number); });
  }
  SurfaceUpdate become(const Grown& change, DepthRenewal depths = DepthRenewal::now) {
    std::unique_ptr<Visibility> now = make_ray_visibility(change.surface->mesh);
    const SurfaceUpdate update = GeometryFollower(planner).update_surface(
        change.surface, *now, change.growth.previous_cell, change.growth.changed, depths);
    surface = change.surface;
    visibility = std::move(now);
    return update;
  }

  std::shared_ptr<const Surface> surface;
  std::unique_ptr<Visibility> visibility;
  Atlas atlas;
  Planner planner;
};

std::vector<ViewSlot> sorted(std::vector<ViewSlot> slots) {
  std::sort(slots.begin(), slots.end());
  return slots;
}

// As if the scene had been planned with this geometry from the start.
void check_against_new_start(const PlannedSurface& scene) {
  PlannedSurface fresh(scene.surface, false);
  for (ViewSlot slot{0}; slot < scene.atlas.size(); ++slot) fresh.keep(slot);
  CHECK(scene.planner.store().summed_coverage() == Approx(fresh.planner.store().summed_coverage()).margin(1e-5));
  std::size_t different = 0;
  for (CellId cell{0}; cell < scene.surface->cells.cells.size(); ++cell) {
    different += sorted(scene.atlas.references(cell)) != sorted(fresh.atlas.references(cell));
  }
  CHECK(different == 0);
  for (ViewSlot slot{0}; slot < scene.atlas.size(); ++slot) {
    CHECK(scene.atlas.view(slot)->mask->depth == fresh.atlas.view(slot)->mask->depth);
    CHECK(scene.atlas.view(slot)->mask->validity == fresh.atlas.view(slot)->mask->validity);
  }
  // What was seen before something came in its way stays seen.
  const std::vector<std::uint8_t> seen = scene.atlas.snapshot().cell_seen;
  const std::vector<std::uint8_t> seen_fresh = fresh.atlas.snapshot().cell_seen;
  CHECK(std::equal(seen.begin(), seen.end(), seen_fresh.begin(), std::greater_equal<>()));
}

TEST_CASE("where all cells are new, the store is compared with what it still holds, and with what is passed by") {
  const bool demand = GENERATE(false, true);
  PlannerOptions options = options_for_update(false, demand);
  options.max_loss_db = 0.5;
  const auto surface = room_surface();
  const auto visibility = make_ray_visibility(surface->mesh);
  Atlas atlas(surface, kMostViews);
  Planner planner(atlas, *visibility, options);
  for (std::size_t number = 0; number < kMostViews; ++number) {
    const Camera camera = room_camera(number);
    planner.force_store("view " + std::to_string(number), camera, [&] { return pattern_photograph(camera, number); });
  }
  const std::size_t cells = surface->cells.cells.size();
  GeometryFollower(planner).update_surface(surface, *visibility, std::vector<CellId>(cells, CellId::none),
                                           std::vector<std::uint8_t>(cells, 1));
  CHECK(Pruning(planner).predicted_loss().gap == Approx(0).margin(1e-5));
  const std::vector<ThinningStep> order = Hindsight(planner).thinning_order();
  REQUIRE(order.size() == kMostViews);
  Pruning(planner).evict(std::vector<ViewSlot>{order[0].slot, order[1].slot, order[2].slot, order[3].slot});
  const double gap = Pruning(planner).predicted_loss().gap;
  CHECK(gap == Approx(order[3].gap).margin(1e-5));
  CHECK(gap > 1e-3);
  // A view that no cell of the new surface knows of yet.
  planner.count_demand(room_camera(kMostViews + 3));
  CHECK(Pruning(planner).predicted_loss().gap > gap);
}

TEST_CASE("a surface that appears, moves and disappears leaves the store as if it had been there from the start") {
  PlannedSurface scene(room_surface(), false);
  for (std::size_t i = 0; i < kMostViews; ++i) scene.keep(i);
  const Mesh bare = scene.surface->mesh;

  const Grown appeared = grown(*scene.surface, with_panel(bare, 0.5f));
  REQUIRE(appeared.surface->cells.cells.size() > scene.surface->cells.cells.size());
  const SurfaceUpdate appearing = scene.become(appeared);
  CHECK(appearing.views_seen_again > 0);
  CHECK(appearing.depths_made_again > 0);
  check_against_new_start(scene);

  // The same faces elsewhere: a mapping that is known, not found.
  std::vector<FaceId> same;
  for (std::uint32_t face = 0; face < scene.surface->mesh.faces.size(); ++face) same.emplace_back(face);
  const SurfaceUpdate moving = scene.become(grown(*scene.surface, with_panel(bare, 0.9f), same));
  CHECK(moving.depths_made_again > 0);
  check_against_new_start(scene);

  const SurfaceUpdate disappearing = scene.become(grown(*scene.surface, bare));
  CHECK(disappearing.depths_made_again > 0);
  check_against_new_start(scene);
}

// Counts the pixels that are wanted of it.
class WantedPixelCounter final : public Visibility {
 public:
  explicit WantedPixelCounter(const Mesh& mesh) : rays_(make_ray_visibility(mesh)) {}
  using Visibility::trace;
  void trace(const Camera& camera, VisibilityBuffer& buffer) const override { rays_->trace(camera, buffer); }
  void trace_wanted(const Camera& camera, std::span<const std::uint8_t> wanted,
                    VisibilityBuffer& buffer) const override {
    all_ += wanted.size();
    wanted_ += static_cast<std::size_t>(std::count_if(wanted.begin(), wanted.end(), [](auto one) { return one != 0; }));
    rays_->trace_wanted(camera, wanted, buffer);
  }
  [[nodiscard]] double share() const { return static_cast<double>(wanted_) / static_cast<double>(all_); }

 private:
  std::unique_ptr<Visibility> rays_;
  mutable std::size_t all_ = 0, wanted_ = 0;
};

TEST_CASE("only pixels that may show a change are looked at again, and the store is as if all had been") {
  PlannedSurface scene(room_surface(), false);
  for (std::size_t i = 0; i < kMostViews; ++i) scene.keep(i);
  const Mesh bare = scene.surface->mesh;
  bool is_first = true;
  for (const float x : {0.5F, 0.6F, -0.7F, 1.8F, 0.5F}) {
    CAPTURE(x);
    const Grown change = grown(*scene.surface, with_panel(bare, x));
    auto now = std::make_unique<WantedPixelCounter>(change.surface->mesh);
    (void)GeometryFollower(scene.planner)
        .update_surface(change.surface, *now, change.growth.previous_cell, change.growth.changed);
    CHECK((now->share() == 1) == is_first);  // no picture was kept of what was offered
    is_first = false;
    scene.surface = change.surface;
    scene.visibility = std::move(now);
    check_against_new_start(scene);
  }
}

TEST_CASE("what a view shows is counted as if it were traced anew, wherever the surface changes") {
  const auto surface = room_surface();
  const Mesh bare = surface->mesh;
  std::mt19937 random(3);
  std::shared_ptr<const Surface> before = surface;
  CellPictures pictures;
  for (int round = 0; round < 12; ++round) {
    CAPTURE(round);
    const float x = std::uniform_real_distribution<float>(-1.9F, 1.9F)(random);
    const Grown change = grown(*before, with_panel(bare, x));
    const auto visibility = make_ray_visibility(change.surface->mesh);
    std::vector<CellId> now(before->cells.cells.size(), CellId::none);
    std::vector<ChangedSphere> changed;
    const auto add = [&](const Cell& cell) { changed.push_back({cell.centroid, cell.radius}); };
    for (CellId cell{0}; cell < change.growth.changed.size(); ++cell) {
      if (change.growth.changed[cell] == 0) {
        now[change.growth.previous_cell[cell]] = cell;
      } else {
        add(change.surface->cells.cells[cell]);
      }
    }
    for (CellId cell{0}; cell < now.size(); ++cell) {
      if (now[cell] == CellId::none) add(before->cells.cells[cell]);
    }
    pictures.follow(now, changed);
    for (ViewSlot slot{0}; slot < kMostViews; ++slot) {
      if ((round + slot) % 3 == 0) continue;  // a picture that is not counted keeps what has changed meanwhile
      const Camera camera = room_camera(slot).shrunk_to(slot % 2 == 0 ? 64 : 161);
      const std::vector<CellPixels> counted = pictures.count(slot, camera, *visibility, change.surface->cells);
      const std::vector<CellPixels> anew = count_cell_pixels(visibility->trace(camera), change.surface->cells);
      REQUIRE(counted.size() == anew.size());
      for (std::size_t i = 0; i < anew.size(); ++i) {
        REQUIRE(counted[i].cell == anew[i].cell);
        REQUIRE(counted[i].pixels == anew[i].pixels);
      }
    }
    before = change.surface;
  }
}

TEST_CASE("depths that are left for later follow view by view, once for two surfaces") {
  PlannedSurface scene(room_surface(), false);
  for (std::size_t i = 0; i < kMostViews; ++i) scene.keep(i);
  const Mesh bare = scene.surface->mesh;
  std::vector<std::shared_ptr<const StoredView>> before;
  for (ViewSlot slot{0}; slot < kMostViews; ++slot) before.push_back(scene.atlas.view(slot));
  CHECK_FALSE(GeometryFollower(scene.planner).has_old_depths());
  CHECK_FALSE(GeometryFollower(scene.planner).renew_depth());

  std::uint32_t seen_again = 0;
  for (const float height : {0.5F, 0.9F}) {
    const SurfaceUpdate update = scene.become(grown(*scene.surface, with_panel(bare, height)), DepthRenewal::later);
    CHECK(update.depths_made_again == 0);
    seen_again += update.views_seen_again;
  }
  for (ViewSlot slot{0}; slot < kMostViews; ++slot) CHECK(scene.atlas.view(slot) == before[slot]);
  std::uint32_t renewed = 0;
  while (GeometryFollower(scene.planner).renew_depth()) ++renewed;
  CHECK(renewed > 0);
  CHECK(renewed < seen_again);
  CHECK_FALSE(GeometryFollower(scene.planner).has_old_depths());
  check_against_new_start(scene);
}

TEST_CASE("views that cannot see a change are left alone") {
  PlannedSurface scene(room_surface(), false);
  for (std::size_t i = 0; i < kMostViews; ++i) scene.keep(i);
  std::vector<std::shared_ptr<const StoredView>> before;
  for (ViewSlot slot{0}; slot < kMostViews; ++slot) before.push_back(scene.atlas.view(slot));
  const SurfaceUpdate update = scene.become(grown(*scene.surface, with_panel(scene.surface->mesh, 1.8f)));
  CHECK(update.views_seen_again < kMostViews);
  std::uint32_t touched = 0;
  for (ViewSlot slot{0}; slot < kMostViews; ++slot) touched += scene.atlas.view(slot) != before[slot];
  CHECK(touched == update.depths_made_again);
  CHECK(touched >= 1);
  CHECK(touched < kMostViews);
}

TEST_CASE("a surface that stays as it is costs nothing and changes nothing") {
  PlannedSurface scene(room_surface(), false);
  for (std::size_t i = 0; i < kMostViews; ++i) scene.keep(i);
  const Snapshot before = scene.atlas.snapshot();
  const SurfaceUpdate update = scene.become(grown(*scene.surface, scene.surface->mesh));
  CHECK(update.views_seen_again == 0);
  const Snapshot now = scene.atlas.snapshot();
  CHECK(now.references.views == before.references.views);
  CHECK(now.references.offsets == before.references.offsets);
  CHECK(now.cell_seen == before.cell_seen);
}

TEST_CASE("the stream goes on after a change of the geometry, with refinement") {
  // Without demand, only what is stored changes what the store is worth.
  PlannedSurface scene(room_surface(), true, false);
  for (std::size_t i = 0; i < kMostViews; ++i) {
    const Camera camera = room_camera(i);
    scene.planner.offer("view " + std::to_string(i), camera, pattern_photograph(camera, i));
  }
  scene.become(grown(*scene.surface, with_panel(scene.surface->mesh, 0.5f)));
  double before = scene.planner.store().summed_coverage();
  for (std::size_t i = kMostViews; i < 3 * kMostViews; ++i) {
    const Camera camera = room_camera(i);
    const Verdict verdict = scene.planner.offer("view " + std::to_string(i), camera, pattern_photograph(camera, i));
    if (verdict.decision == Decision::kept || verdict.decision == Decision::replaced) {
      CHECK(scene.planner.store().summed_coverage() - before == Approx(verdict.gain).margin(1e-5));
    }
    before = scene.planner.store().summed_coverage();
  }
  CHECK_NOTHROW(scene.planner.refiner().polish());
}

TEST_CASE("what is said of the cells must fit the surface") {
  PlannedSurface scene(room_surface(), false);
  scene.keep(0);
  const Grown same = grown(*scene.surface, scene.surface->mesh);
  const double before = scene.planner.store().summed_coverage();
  const std::vector<std::uint8_t> none;
  CHECK_THROWS_AS(
      GeometryFollower(scene.planner).update_surface(same.surface, *scene.visibility, same.growth.previous_cell, none),
      std::invalid_argument);
  std::vector<CellId> unknown = same.growth.previous_cell;
  unknown[3] = CellId::none;
  CHECK_THROWS_WITH(
      GeometryFollower(scene.planner).update_surface(same.surface, *scene.visibility, unknown, same.growth.changed),
      Catch::Contains("cell 3"));
  std::vector<CellId> twice = same.growth.previous_cell;
  twice[4] = twice[3];
  CHECK_THROWS_WITH(
      GeometryFollower(scene.planner).update_surface(same.surface, *scene.visibility, twice, same.growth.changed),
      Catch::Contains("cell 4") && Catch::Contains("as another cell was"));
  CHECK(scene.planner.store().summed_coverage() == before);
}

Camera drifted(Camera camera) {
  camera.cam_from_world_translation += glm::dvec3(0.2, -0.1, 0.15);
  return camera;
}

TEST_CASE("after a loop closure the store is as if its views had come with the later poses") {
  PlannedSurface scene(room_surface(), false);
  std::vector<ViewPose> closed;
  for (std::size_t number = 0; number < kMostViews; ++number) {
    const Camera camera = room_camera(number);
    const bool drifts = number % 2 == 1;
    const Verdict verdict =
        scene.planner.force_store("view " + std::to_string(number), drifts ? drifted(camera) : camera,
                                  [&] { return pattern_photograph(camera, number); });
    REQUIRE(verdict.slot);
    if (drifts) closed.push_back({*verdict.slot, camera});
  }
  const Snapshot before = scene.atlas.snapshot();
  const SurfaceUpdate update = GeometryFollower(scene.planner).move_views(closed);
  CHECK(update.views_seen_again == closed.size());
  CHECK(update.depths_made_again == closed.size());
  check_against_new_start(scene);
  for (const ViewPose& pose : closed) {
    CHECK(scene.atlas.view(pose.slot)->camera.center() == pose.camera.center());
    CHECK(before.views[pose.slot]->camera.center() != pose.camera.center());
  }
}

// Turns a scene about the third axis and shifts it.
struct SceneMove {
  glm::dmat3 turn{0.6, 0.8, 0, -0.8, 0.6, 0, 0, 0, 1};
  glm::dvec3 shift{0.5, -3, 0.25};

  [[nodiscard]] Camera of(Camera camera) const {
    camera.cam_from_world_rotation = camera.cam_from_world_rotation * glm::transpose(turn);
    camera.cam_from_world_translation -= camera.cam_from_world_rotation * shift;
    return camera;
  }
  [[nodiscard]] std::shared_ptr<const Surface> of(const Surface& surface) const {
    auto moved = std::make_shared<Surface>(surface);
    for (glm::vec3& position : moved->mesh.positions) position = turn * glm::dvec3(position) + shift;
    moved->cells = measure_cells(moved->mesh, surface.cells.cell_of_face, surface.cells.size);
    return moved;
  }
};

TEST_CASE("a scene that moves with its views keeps what they show, and is as if it had been there from the start") {
  const bool demand = GENERATE(false, true);
  PlannedSurface scene(room_surface(), false, demand);
  for (std::size_t number = 0; number < kMostViews; ++number) scene.keep(number);
  const Snapshot before = scene.atlas.snapshot();
  const double covered = scene.planner.store().summed_coverage();
  const SceneMove move;
  const std::shared_ptr<const Surface> surface = move.of(*scene.surface);
  std::unique_ptr<Visibility> visibility = make_ray_visibility(surface->mesh);
  std::vector<ViewPose> poses;
  for (ViewSlot slot{0}; slot < kMostViews; ++slot) poses.push_back({slot, move.of(before.views[slot]->camera)});
  GeometryFollower follower(scene.planner);
  follower.move_scene(surface, *visibility, poses);
  scene.surface = surface;
  scene.visibility = std::move(visibility);
  const Snapshot after = scene.atlas.snapshot();
  CHECK(after.surface == surface);
  CHECK(after.references.views == before.references.views);
  CHECK(after.references.offsets == before.references.offsets);
  CHECK(scene.planner.store().summed_coverage() == covered);
  for (ViewSlot slot{0}; slot < kMostViews; ++slot) {
    CHECK(after.views[slot]->mask == before.views[slot]->mask);
    CHECK(after.views[slot]->camera.center() == poses[slot].camera.center());
  }
  // The depths that are made again are those of the moved surface.
  std::size_t renewed = 0;
  while (follower.renew_depth()) ++renewed;
  CHECK(renewed == kMostViews);
  PlannedSurface fresh(surface, false, demand);
  for (std::size_t number = 0; number < kMostViews; ++number) {
    fresh.planner.force_store("view " + std::to_string(number), move.of(room_camera(number)),
                              [&] { return pattern_photograph(room_camera(number), number); });
  }
  for (ViewSlot slot{0}; slot < kMostViews; ++slot) {
    CHECK(scene.atlas.view(slot)->mask->depth == fresh.atlas.view(slot)->mask->depth);
  }
  CHECK(covered == Approx(fresh.planner.store().summed_coverage()).epsilon(0.02));
}

TEST_CASE("where views have not moved as the surface has, they are counted again with the next surface") {
  PlannedSurface scene(room_surface(), false);
  for (std::size_t number = 0; number < kMostViews; ++number) scene.keep(number);
  // The surface stays where it is, as one that no frame has measured, and one view in four looks elsewhere.
  const auto same = std::make_shared<Surface>(*scene.surface);
  std::vector<ViewPose> poses;
  for (ViewSlot slot{0}; slot < kMostViews; slot = ViewSlot(slot + 4))
    poses.push_back({slot, drifted(room_camera(slot))});
  GeometryFollower(scene.planner).move_scene(same, *scene.visibility, poses);
  scene.surface = same;
  scene.become(grown(*same, same->mesh));
  PlannedSurface fresh(scene.surface, false);
  for (ViewSlot slot{0}; slot < kMostViews; ++slot) {
    const Camera camera = slot % 4 == 0 ? drifted(room_camera(slot)) : room_camera(slot);
    fresh.planner.force_store("view " + std::to_string(slot), camera,
                              [&] { return pattern_photograph(room_camera(slot), slot); });
  }
  CHECK(scene.planner.store().summed_coverage() == Approx(fresh.planner.store().summed_coverage()).margin(1e-5));
  for (CellId cell{0}; cell < scene.surface->cells.cells.size(); ++cell) {
    CHECK(sorted(scene.atlas.references(cell)) == sorted(fresh.atlas.references(cell)));
  }
}

TEST_CASE("a scene moves whole, or stays where it is") {
  PlannedSurface scene(room_surface(), false);
  scene.keep(0);
  const SceneMove move;
  const std::shared_ptr<const Surface> surface = move.of(*scene.surface);
  const auto visibility = make_ray_visibility(surface->mesh);
  GeometryFollower follower(scene.planner);
  const std::vector<ViewPose> poses{{ViewSlot{0}, move.of(room_camera(0))}};
  const std::vector<ViewPose> of_none{{ViewSlot{7}, move.of(room_camera(0))}};
  CHECK_THROWS_AS(follower.move_scene(surface, *visibility, of_none), std::logic_error);
  CHECK_THROWS_AS(follower.move_scene(nullptr, *visibility, poses), std::invalid_argument);
  const Mesh other = with_panel(scene.surface->mesh, 0);
  CHECK_THROWS_WITH(follower.move_scene(grown(*scene.surface, other).surface, *visibility, poses),
                    Catch::Contains("other faces or cells"));
  CHECK(scene.atlas.surface() == scene.surface);
  CHECK(scene.atlas.view(ViewSlot{0})->camera.center() == room_camera(0).center());
  CHECK_FALSE(follower.has_old_depths());
}

TEST_CASE("a loop closure keeps what refinement corrected of a pose") {
  PlannerOptions options = options_for_update(true, true);
  options.refinement.alignment.pose = true;
  const auto surface = room_surface();
  const auto visibility = make_ray_visibility(surface->mesh);
  Atlas atlas(surface, kMostViews);
  Planner planner(atlas, *visibility, options);
  for (std::size_t number = 0; number < kMostViews; ++number) {
    Camera given = room_camera(number);
    given.cam_from_world_translation.x += 0.02;  // where refinement takes it from differs from view to view
    planner.force_store("view " + std::to_string(number), given,
                        [&] { return pattern_photograph(room_camera(number), number); });
  }
  for (ViewSlot slot{0}; slot < kMostViews; ++slot) {
    const Camera refined = atlas.view(slot)->camera;
    Camera given = room_camera(slot);
    given.cam_from_world_translation.x += 0.02;
    const glm::dvec3 corrected = refined.cam_from_world(given.center());
    const Camera closed = drifted(given);
    GeometryFollower(planner).move_views(std::vector<ViewPose>{{slot, closed}});
    CHECK(glm::distance(atlas.view(slot)->camera.cam_from_world(closed.center()), corrected) < 1e-9);
  }
}

TEST_CASE("a loop closure that names a slot without a view, or a view twice, changes nothing") {
  PlannedSurface scene(room_surface(), false);
  scene.keep(0);
  scene.keep(1);
  const double covered = scene.planner.store().summed_coverage();
  const Camera camera = drifted(room_camera(0));
  const std::vector<ViewPose> of_none{{ViewSlot{0}, camera}, {ViewSlot{7}, camera}};
  CHECK_THROWS_AS(GeometryFollower(scene.planner).move_views(of_none), std::logic_error);
  const std::vector<ViewPose> twice{{ViewSlot{0}, camera}, {ViewSlot{0}, camera}};
  CHECK_THROWS_AS(GeometryFollower(scene.planner).move_views(twice), std::invalid_argument);
  CHECK(scene.atlas.view(ViewSlot{0})->camera.center() == room_camera(0).center());
  CHECK(scene.planner.store().summed_coverage() == covered);
}

}  // namespace
}  // namespace lumatlas
