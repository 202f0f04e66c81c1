// SPDX-License-Identifier: GPL-3.0-or-later
// The laws of a view's three parts: what a new pose or a new mask leaves, and shares.
#include <atomic>
#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "atlas/atlas.h"
#include "tests/support/scenes/view_parts.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

constexpr TileOptions kPartsLayout{8, 2, 0};
constexpr std::uint32_t kPartsViews = 3;

// What each tile of a view shows: cell 0.
std::vector<ShownCell> shows_first_cell() {
  std::vector<ShownCell> shown;
  for (std::uint32_t tile = 0; tile < 6; ++tile) shown.push_back({tile, 0, 1});
  return shown;
}

// Three views of 24 x 16 pixels that cell 0 refers to, and a free slot.
std::unique_ptr<Atlas> store_of_three() {
  const auto surface = wall_and_panel(5);
  auto atlas = std::make_unique<Atlas>(surface, kPartsViews + 1, kPartsLayout);
  std::vector<ViewSlot> slots;
  for (std::uint32_t number = 0; number < kPartsViews; ++number) {
    slots.push_back(atlas->insert(traced_view(*surface, std::string(1, static_cast<char>('a' + number)),
                                              forward_camera(24, 16), position_photograph(24, 16, number)),
                                  shows_first_cell()));
  }
  atlas->set_references(0, slots);
  return atlas;
}

// The poses of all three, `step` to the side.
std::vector<ViewPose> poses_at(double step) {
  std::vector<ViewPose> poses;
  for (ViewSlot slot{0}; slot < kPartsViews; ++slot) {
    poses.push_back({slot, forward_camera(24, 16, {0.01 * step, 0.1 * slot, 0})});
  }
  return poses;
}

double step_of(const StoredView& view) {
  return -view.camera.cam_from_world_translation.x / 0.01;
}

TEST_CASE("new poses leave photographs and masks, which snapshots share") {
  const auto atlas = store_of_three();
  atlas->set_gain(1, {2, 1, 1});
  const Snapshot before = atlas->snapshot();
  const std::vector<ViewPose> poses = poses_at(7);
  atlas->set_poses(poses);
  const Snapshot after = atlas->snapshot();
  for (ViewSlot slot{0}; slot < kPartsViews; ++slot) {
    const StoredView &old = *before.views[slot], &now = *after.views[slot];
    CHECK(now.photograph == old.photograph);  // the same object: a new pose takes no memory for pixels
    CHECK(now.mask == old.mask);
    CHECK(now.name == old.name);
    CHECK(now.camera.cam_from_world_translation == poses[slot].camera.cam_from_world_translation);
    CHECK(old.camera.cam_from_world_translation == glm::dvec3(0));
    CHECK(atlas->shown(slot)->size() == 6);
  }
  CHECK(after.gains == before.gains);
  CHECK(after.references.views == before.references.views);
  CHECK(after.tiles.places == before.tiles.places);
}

TEST_CASE("one pose that is refused leaves all views where they are") {
  const auto atlas = store_of_three();
  const Snapshot before = atlas->snapshot();
  const auto refused = [&](const std::function<void(std::vector<ViewPose>&)>& spoil, const std::string& sentence) {
    std::vector<ViewPose> poses = poses_at(7);
    spoil(poses);
    CHECK_THROWS_WITH(atlas->set_poses(poses), Catch::Contains(sentence));
    CHECK(atlas->snapshot().views == before.views);
  };
  using Poses = std::vector<ViewPose>;
  refused([](Poses& poses) { poses[2].slot = 3; }, "atlas: slot 3 holds no view");
  refused([](Poses& poses) { poses[2].slot = 99; }, "atlas: slot 99 holds no view");
  refused([](Poses& poses) { poses[2].slot = 0; }, "atlas: the poses have slot 0 twice, must have each once");
  refused([](Poses& poses) { poses[2].camera.fx = 0; }, "fx");
  refused([](Poses& poses) { poses[2].camera.width = 25; },
          "view c: the new pose has an image of 25x16, must be as large as before, 24x16");
  atlas->set_poses({});
  CHECK(atlas->snapshot().views == before.views);
}

TEST_CASE("a surface that moves with views is replaced together with their poses, or not at all") {
  const auto atlas = store_of_three();
  const Snapshot before = atlas->snapshot();
  const auto surface = std::make_shared<Surface>(*before.surface);
  for (glm::vec3& position : surface->mesh.positions) position.x -= 0.07F;
  std::vector<CellId> same(surface->cells.cells.size());
  for (CellId cell{0}; cell < same.size(); ++cell) same[cell] = cell;
  std::vector<ViewPose> poses = poses_at(7);
  poses[1].slot = ViewSlot{3};
  CHECK_THROWS_WITH(atlas->replace_surface(surface, same, poses), Catch::Contains("atlas: slot 3 holds no view"));
  poses[1].slot = ViewSlot{0};
  CHECK_THROWS_WITH(atlas->replace_surface(surface, same, poses), Catch::Contains("slot 0 twice"));
  CHECK(atlas->snapshot().views == before.views);
  CHECK(atlas->snapshot().surface == before.surface);
  poses = poses_at(7);
  atlas->replace_surface(surface, same, poses);
  const Snapshot after = atlas->snapshot();
  CHECK(after.surface == surface);
  for (const ViewPose& pose : poses) {
    CHECK(step_of(*after.views[pose.slot]) == Approx(7));
    CHECK(after.views[pose.slot]->mask == before.views[pose.slot]->mask);
    CHECK(step_of(*before.views[pose.slot]) == 0);
  }
  CHECK(after.references.views == before.references.views);
}

TEST_CASE("no snapshot has a surface and poses of different moves") {
  const auto atlas = store_of_three();
  constexpr int kMoves = 1000;
  std::vector<std::shared_ptr<const Surface>> surfaces;
  for (int move = 0; move < 2; ++move) surfaces.push_back(std::make_shared<Surface>(*atlas->surface()));
  std::vector<CellId> same(surfaces[0]->cells.cells.size());
  for (CellId cell{0}; cell < same.size(); ++cell) same[cell] = cell;
  atlas->replace_surface(surfaces[0], same);
  std::atomic<bool> done{false};
  std::thread mover([&] {
    for (int move = 1; move <= kMoves; ++move) atlas->replace_surface(surfaces[move % 2], same, poses_at(move % 2));
    done = true;
  });
  std::thread masker([&] {
    while (!done) atlas->replace_mask(1, std::make_shared<ViewMask>(*atlas->view(1)->mask));
  });
  int torn = 0;
  while (!done) {
    const Snapshot now = atlas->snapshot();
    const double step = now.surface == surfaces[1] ? 1 : 0;
    for (const auto& view : now.views) torn += view && std::abs(step_of(*view) - step) > 0.5 ? 1 : 0;
  }
  mover.join();
  masker.join();
  CHECK(torn == 0);
}

TEST_CASE("a new mask leaves the photograph and the pose") {
  const auto atlas = store_of_three();
  atlas->set_poses(poses_at(2));
  const Snapshot before = atlas->snapshot();
  const auto mask = std::make_shared<ViewMask>(*before.views[1]->mask);
  mask->validity.values().assign(mask->validity.size(), 7);
  atlas->replace_mask(1, mask, {{0, 0, 3}});
  const Snapshot after = atlas->snapshot();
  CHECK(after.views[1]->mask == mask);
  CHECK(after.views[1]->photograph == before.views[1]->photograph);
  CHECK(step_of(*after.views[1]) == Approx(2));
  CHECK(atlas->shown(1)->size() == 1);
  CHECK(before.views[1]->mask->validity != mask->validity);
  CHECK(after.views[0] == before.views[0]);

  const auto small = std::make_shared<ViewMask>(*mask);
  small->depth.values().pop_back();
  CHECK_THROWS_WITH(atlas->replace_mask(1, small), Catch::Contains("view b: depth has 383 values, must have 384"));
  CHECK_THROWS_WITH(atlas->replace_mask(1, nullptr), Catch::Contains("view b: mask is null"));
  CHECK_THROWS_WITH(atlas->replace_mask(1, mask, {{6, 0, 3}}), Catch::Contains("shown[0] is of tile 6"));
  CHECK_THROWS_WITH(atlas->replace_mask(1, mask, {{0, 5, 3}}), Catch::Contains("shown[0] is of cell 5"));
  CHECK_THROWS_AS(atlas->replace_mask(3, mask), std::logic_error);
  CHECK(atlas->snapshot().views == after.views);
}

TEST_CASE("a snapshot has all new poses or none, and no thread undoes another's change of a part") {
  const auto atlas = store_of_three();
  constexpr int kSteps = 2000;
  std::atomic<bool> done{false};
  std::atomic<int> torn{0};
  std::thread poser([&] {
    for (int step = 1; step <= kSteps; ++step) atlas->set_poses(poses_at(step));
    done = true;
  });
  std::thread masker([&] {
    for (int step = 1; step <= kSteps; ++step) {
      const auto mask = std::make_shared<ViewMask>(*atlas->view(1)->mask);
      mask->trust.values().assign(mask->depth.size(), static_cast<std::uint8_t>(step));
      atlas->replace_mask(1, mask, shows_first_cell());
    }
  });
  double last = 0;
  while (!done) {
    const Snapshot snapshot = atlas->snapshot();
    const double step = step_of(*snapshot.views[0]);
    for (ViewSlot slot{1}; slot < kPartsViews; ++slot) torn += step_of(*snapshot.views[slot]) == step ? 0 : 1;
    torn += step >= last ? 0 : 1;
    last = step;
  }
  poser.join();
  masker.join();
  CHECK(torn == 0);
  const Snapshot end = atlas->snapshot();
  for (ViewSlot slot{0}; slot < kPartsViews; ++slot) CHECK(step_of(*end.views[slot]) == Approx(kSteps));
  CHECK(end.views[1]->mask->trust[0] == static_cast<std::uint8_t>(kSteps));
}

}  // namespace
}  // namespace lumatlas
