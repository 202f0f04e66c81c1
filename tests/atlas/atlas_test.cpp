// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/atlas.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/scenes/view_parts.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

using Slots = std::vector<ViewSlot>;
using Offsets = std::vector<std::uint32_t>;
using CellIds = std::vector<CellId>;

constexpr std::uint32_t kCells = 5;

// A view of one pixel that can be told from others.
StoredView tiny_view(const std::string& name) {
  StoredView view;
  view.name = name;
  view.camera = forward_camera(1, 1);
  view.photograph = std::make_shared<const StoredPhotograph>(Photograph{1, 1, {1, 2, 3}, {}});
  own_mask(view).depth = std::vector<float>{4};
  own_mask(view).validity = std::vector<std::uint8_t>{255};
  return view;
}

TEST_CASE("the example that atlas.h opens with does what the header says") {
  const std::shared_ptr<const Surface> surface = wall_and_panel(kCells);
  const Camera camera = forward_camera(32, 32), corrected = oblique_camera(32, 32, 0.01, {0.01, 0, 0});
  const Photograph photograph = position_photograph(32, 32);
  // The header's lines.
  Atlas atlas(surface, 100);
  VisibilityBuffer visible = make_ray_visibility(surface->mesh)->trace(camera);
  const std::vector<CellPixels> seen = count_cell_pixels(visible, surface->cells);
  const ViewSlot slot = atlas.insert(make_stored_view("a.jpg", camera, photograph, std::move(visible), {}));
  atlas.mark_seen(seen);
  for (const CellPixels& part : seen) atlas.set_references(part.cell, {slot});
  const Snapshot drawn = atlas.snapshot();
  atlas.set_poses(std::vector{ViewPose{slot, corrected}});
  for (const CellPixels& part : seen) atlas.set_references(part.cell, {});
  atlas.erase(slot);
  // Until here.
  REQUIRE_FALSE(seen.empty());
  CHECK_NOTHROW(check(drawn));
  CHECK(drawn.references.views.size() == seen.size());
  CHECK(drawn.views[slot]->camera.cam_from_world_translation == camera.cam_from_world_translation);
  CHECK(atlas.size() == 0);
  CHECK(atlas.snapshot().cell_seen == drawn.cell_seen);
}

TEST_CASE("a stored view has the depth that its camera sees and a mask of it") {
  const auto surface = wall_and_panel();
  const Camera camera = forward_camera(32, 32);
  const StoredView view = traced_view(*surface, "a", camera, position_photograph(32, 32));
  CHECK(view.name == "a");
  CHECK(view.photograph->whole().rgb == position_photograph(32, 32).rgb);
  REQUIRE(view.mask->depth.size() == 32 * 32);
  CHECK(view.mask->depth[32 * 16 + 16] == Approx(2).epsilon(1e-6));  // the panel; processors round differently
  CHECK(view.mask->depth[32 * 4 + 4] == Approx(4).epsilon(1e-6));    // the wall
  CHECK(view.mask->trust.empty());
  CHECK(view.mask->validity == validity_mask(view.photograph->whole(), view.mask->depth.all(), {}, {}));
}

TEST_CASE("a stored view's parts must be as large as its camera's image") {
  const auto surface = wall_and_panel();
  const Camera camera = forward_camera(8, 6);
  const auto visibility = make_ray_visibility(surface->mesh);
  CHECK_THROWS_MATCHES(make_stored_view("a", camera, position_photograph(8, 5), visibility->trace(camera), {}),
                       std::invalid_argument,
                       Catch::Message("view a: the photograph is 8x5, must be as large as its camera, 8x6"));
  CHECK_THROWS_MATCHES(
      make_stored_view("a", camera, position_photograph(8, 6), visibility->trace(camera.scaled_to(4, 3)), {}),
      std::invalid_argument,
      Catch::Message("view a: the visibility buffer is 4x3, must be as large as its camera, 8x6"));
}

TEST_CASE("a stored view keeps its trust mask, and its validity follows it") {
  const auto surface = wall_and_panel();
  const Camera camera = forward_camera(8, 6);
  const auto visibility = make_ray_visibility(surface->mesh);
  const auto view_with = [&](const std::vector<std::uint8_t>& trust) {
    return make_stored_view("a", camera, position_photograph(8, 6), visibility->trace(camera), {0.05, 0, 1}, trust);
  };
  std::vector<std::uint8_t> trust(8 * 6, 255);
  trust[8 * 3 + 1] = 0;
  const StoredView view = view_with(trust);
  CHECK(view.mask->trust == trust);
  CHECK(view.mask->validity == validity_mask(view.photograph->whole(), view.mask->depth.all(), trust, {0.05, 0, 1}));
  std::vector<std::uint8_t> contradicted_there = view_with({}).mask->validity.all();
  REQUIRE(contradicted_there[8 * 3 + 1] == 255);
  contradicted_there[8 * 3 + 1] = 1;
  CHECK(view.mask->validity == contradicted_there);
  trust.pop_back();
  CHECK_THROWS_MATCHES(
      view_with(trust), std::invalid_argument,
      Catch::Message("validity: trust has 47 values, must have one per pixel of the photograph, or none"));
}

TEST_CASE("a view whose lists are not of its camera's size is refused, and the store stays as it was") {
  Atlas atlas(wall_and_panel(kCells), 2);
  atlas.insert(tiny_view("old"));
  const auto refused = [&](const std::function<void(StoredView&)>& damage, const std::string& sentence) {
    StoredView view = tiny_view("a");
    damage(view);
    CHECK_THROWS_MATCHES(atlas.insert(view), std::invalid_argument, Catch::Message("view a: " + sentence));
    CHECK_THROWS_MATCHES(atlas.replace(0, view), std::invalid_argument, Catch::Message("view a: " + sentence));
    CHECK(atlas.size() == 1);
    CHECK(atlas.view(0)->name == "old");
  };
  refused([](StoredView& v) { v.photograph = std::make_shared<const StoredPhotograph>(position_photograph(2, 1)); },
          "the photograph is 2x1, must be as large as its camera, 1x1");
  refused([](StoredView& v) { own_mask(v).depth.values().clear(); },
          "depth has 0 values, must have 1 for its camera's image");
  refused([](StoredView& v) { own_mask(v).validity.values().clear(); },
          "validity has 0 values, must have 1 for its camera's image");
  refused(
      [](StoredView& v) {
        own_mask(v).trust.values() = {1, 2};
      },
      "trust has 2 values, must have 1 for its camera's image");
  refused(
      [](StoredView& v) {
        own_mask(v).rim.values() = {1, 2};
      },
      "rim has 2 values, must have 1 for its camera's image");
  refused([](StoredView& v) { v.camera.fx = 0; }, "camera: fx is 0, must be finite and positive");
}

TEST_CASE("a list of shown cells that is not the view's and the surface's is refused") {
  constexpr TileOptions kLayout{8, 1, 0};
  Atlas atlas(wall_and_panel(kCells), 2, kLayout);
  const Camera camera = forward_camera(20, 10);  // 3 x 2 tiles
  const StoredView view = traced_view(*wall_and_panel(kCells), "a", camera, position_photograph(20, 10));
  const auto refused = [&](const std::vector<ShownCell>& shown, const std::string& sentence) {
    CHECK_THROWS_MATCHES(atlas.insert(view, shown), std::invalid_argument, Catch::Message("view a: " + sentence));
    CHECK(atlas.size() == 0);
  };
  refused({{0, 1, 4}, {6, 0, 4}}, "shown[1] is of tile 6, must be below 6");
  refused({{0, 1, 65}}, "shown[0] has 65 pixels, a tile has 64");
  refused({{0, 1, 4}, {0, 1, 4}}, "shown[1] does not come after the one before it, must rise by tile, then cell");
  refused({{1, 0, 4}, {0, 1, 4}}, "shown[1] does not come after the one before it, must rise by tile, then cell");
  refused({{0, 5, 4}}, "shown[0] is of cell 5, must be below the number of cells, 5: was it made for another surface?");
  Atlas whole(wall_and_panel(kCells), 1);
  CHECK_THROWS_MATCHES(whole.insert(view, {{0, 0, 1}}), std::invalid_argument,
                       Catch::Message("view a: shown has 1 entries, must have none where views are whole"));
}

TEST_CASE("shown cells that were counted before another thread replaced the surface are refused") {
  constexpr TileOptions kLayout{8, 1, 0};
  const auto before = wall_and_panel(30);
  Atlas atlas(before, 2, kLayout);
  const Camera camera = forward_camera(20, 10);
  TiledView tiled = make_tiled_view("a", camera, position_photograph(20, 10),
                                    make_ray_visibility(before->mesh)->trace(camera), before->cells, kLayout, {});
  const std::vector<CellId> previous_cell(2, CellId::none);
  std::thread([&] { atlas.replace_surface(wall_and_panel(2), previous_cell); }).join();
  CHECK_THROWS_AS(atlas.insert(tiled.view, tiled.shown), std::invalid_argument);
  CHECK(atlas.size() == 0);
  CHECK(atlas.snapshot().tiles.resident_tiles() == 0);
}

TEST_CASE("cells and slots that a store does not have are refused by number") {
  Atlas atlas(wall_and_panel(kCells), 2);
  atlas.insert(tiny_view("a"));
  const auto no_cell = Catch::Message("atlas: cell is 5, must be below the number of cells, 5");
  CHECK_THROWS_MATCHES(atlas.references(CellId(kCells)), std::invalid_argument, no_cell);
  CHECK_THROWS_MATCHES(atlas.set_references(CellId(kCells), {0}), std::invalid_argument, no_cell);
  const std::vector<CellPixels> seen{{1, 1}, {CellId{kCells}, 1}};
  CHECK_THROWS_MATCHES(atlas.mark_seen(seen), std::invalid_argument, no_cell);
  CHECK(atlas.snapshot().cell_seen == std::vector<std::uint8_t>(kCells, 0));
  CHECK_THROWS_MATCHES(atlas.view(2), std::invalid_argument,
                       Catch::Message("atlas: slot is 2, must be below the capacity, 2"));
  CHECK_THROWS_MATCHES(atlas.set_references(1, {0, 0}), std::invalid_argument,
                       Catch::Message("atlas: the references of cell 1 have slot 0 twice, must have each once"));
  CHECK(atlas.references(1).empty());
}

TEST_CASE("a store for no views is refused") {
  CHECK_THROWS_MATCHES(Atlas(wall_and_panel(), 0), std::invalid_argument,
                       Catch::Message("atlas: max_views is 0, must be at least 1"));
}

TEST_CASE("a new store is empty") {
  const auto surface = wall_and_panel(kCells);
  const Atlas atlas(surface, 3);
  CHECK(atlas.surface() == surface);
  CHECK(atlas.capacity() == 3);
  CHECK(atlas.size() == 0);
  for (ViewSlot slot{0}; slot < 3; ++slot) CHECK(atlas.view(slot) == nullptr);
  for (CellId cell{0}; cell < kCells; ++cell) CHECK(atlas.references(cell).empty());
  const Snapshot snapshot = atlas.snapshot();
  CHECK(snapshot.surface == surface);
  CHECK(snapshot.views.size() == 3);
  CHECK(snapshot.gains == std::vector<glm::dvec3>(3, glm::dvec3(1)));
  CHECK(snapshot.references.offsets == Offsets(kCells + 1, 0));
  CHECK(snapshot.references.views.empty());
  CHECK(snapshot.cell_seen == std::vector<std::uint8_t>(kCells, 0));
  CHECK(snapshot.vertex_colors == std::vector<glm::u8vec3>(surface->mesh.positions.size(), glm::u8vec3(128)));
}

TEST_CASE("a view goes into the lowest free slot") {
  Atlas atlas(wall_and_panel(), 3);
  CHECK(atlas.insert(tiny_view("a")) == 0);
  CHECK(atlas.insert(tiny_view("b")) == 1);
  CHECK(atlas.insert(tiny_view("c")) == 2);
  atlas.erase(2);
  atlas.erase(0);
  CHECK(atlas.size() == 1);
  CHECK(atlas.insert(tiny_view("d")) == 0);
  CHECK(atlas.view(0)->name == "d");
  CHECK(atlas.view(1)->name == "b");
  CHECK(atlas.view(2) == nullptr);
}

TEST_CASE("a view goes into the slot that the caller chose, if it is free") {
  Atlas atlas(wall_and_panel(), 3);
  atlas.insert_at(1, tiny_view("a"));
  CHECK(atlas.insert(tiny_view("b")) == 0);
  CHECK_THROWS_MATCHES(atlas.insert_at(1, tiny_view("c")), std::logic_error,
                       Catch::Message("atlas: slot 1 holds a view already"));
  CHECK_THROWS_MATCHES(atlas.insert_at(3, tiny_view("c")), std::invalid_argument,
                       Catch::Message("atlas: slot is 3, must be below the capacity, 3"));
  CHECK(atlas.view(1)->name == "a");
  CHECK(atlas.size() == 2);
}

TEST_CASE("a full store takes no view and keeps what it has") {
  Atlas atlas(wall_and_panel(), 2);
  atlas.insert(tiny_view("a"));
  atlas.insert(tiny_view("b"));
  CHECK_THROWS_MATCHES(atlas.insert(tiny_view("c")), std::logic_error,
                       Catch::Message("atlas: insert into a full store"));
  CHECK(atlas.size() == 2);
  CHECK(atlas.view(1)->name == "b");
}

TEST_CASE("a slot that cells refer to cannot be erased") {
  Atlas atlas(wall_and_panel(kCells), 2);
  atlas.insert(tiny_view("a"));
  atlas.insert(tiny_view("b"));
  atlas.set_references(1, {0, 1});
  atlas.set_references(4, {0});
  CHECK_THROWS_MATCHES(atlas.erase(0), std::logic_error,
                       Catch::Message("atlas: erase of slot 0, which 2 cells refer to"));
  CHECK(atlas.view(0)->name == "a");
  atlas.set_references(1, {1});
  CHECK_THROWS_AS(atlas.erase(0), std::logic_error);
  atlas.set_references(4, {});
  atlas.erase(0);
  CHECK(atlas.size() == 1);
}

TEST_CASE("slots without a view can be neither erased nor referred to") {
  Atlas atlas(wall_and_panel(kCells), 2);
  atlas.insert(tiny_view("a"));
  atlas.set_references(0, {0});
  const ViewSlot slot(GENERATE(1u, 2u, 4'000'000'000u));
  const auto sentence = Catch::Message("atlas: slot " + std::to_string(slot) + " holds no view");
  CHECK_THROWS_MATCHES(atlas.erase(slot), std::logic_error, sentence);
  CHECK_THROWS_MATCHES(atlas.set_references(0, {0, slot}), std::logic_error, sentence);
  CHECK(atlas.references(0) == Slots{0});
  CHECK_THROWS_AS(atlas.set_references(CellId(kCells), {0}), std::logic_error);
  atlas.set_references(0, {});
  atlas.erase(0);  // the refused calls left no reference behind
}

TEST_CASE("a replaced view leaves its references and its gain to the next") {
  Atlas atlas(wall_and_panel(kCells), 3);
  atlas.insert(tiny_view("a"));
  atlas.insert(tiny_view("b"));
  atlas.set_references(0, {1, 0});
  atlas.set_references(3, {1});
  atlas.set_gain(1, {2, 3, 4});
  const Snapshot before = atlas.snapshot();
  StoredView moved = tiny_view("b, moved");
  moved.camera = forward_camera(1, 1, {0, 0, -1});
  atlas.replace(1, moved);
  CHECK(atlas.size() == 2);
  CHECK(atlas.view(0)->name == "a");
  CHECK(atlas.view(1)->name == "b, moved");
  CHECK(atlas.view(1)->camera.center() == glm::dvec3(0, 0, -1));
  CHECK(atlas.gain(1) == glm::dvec3(2, 3, 4));
  CHECK(atlas.references(0) == Slots{1, 0});
  CHECK(atlas.references(3) == Slots{1});
  CHECK_THROWS_MATCHES(atlas.erase(1), std::logic_error,
                       Catch::Message("atlas: erase of slot 1, which 2 cells refer to"));
  CHECK(before.views[1]->name == "b");
  CHECK(before.views[1]->camera.center() == glm::dvec3(0));
  CHECK(atlas.snapshot().views[1]->name == "b, moved");
}

TEST_CASE("a snapshot's vertex colours follow a replaced view") {
  const auto surface = wall_and_panel();
  Atlas atlas(surface, 1);
  const Camera camera = forward_camera(32, 32, {0, 0, -1});
  atlas.insert(traced_view(*surface, "a", camera, position_photograph(32, 32)));
  StoredView view = *atlas.view(0);
  view.camera = forward_camera(32, 32, {0.3, -0.2, -1});
  const Snapshot before = atlas.snapshot();
  atlas.replace(0, view);
  CHECK(atlas.snapshot().vertex_colors != before.vertex_colors);
  Atlas fresh(surface, 1);
  fresh.insert(view);
  CHECK(atlas.snapshot().vertex_colors == fresh.snapshot().vertex_colors);
}

TEST_CASE("a slot without a view has none to replace") {
  Atlas atlas(wall_and_panel(), 2);
  atlas.insert(tiny_view("a"));
  const ViewSlot slot(GENERATE(1u, 2u, 4'000'000'000u));
  CHECK_THROWS_MATCHES(atlas.replace(slot, tiny_view("b")), std::logic_error,
                       Catch::Message("atlas: slot " + std::to_string(slot) + " holds no view"));
  CHECK(atlas.size() == 1);
  CHECK(atlas.view(1) == nullptr);
}

TEST_CASE("a view's gain can be changed, and ends with the view") {
  Atlas atlas(wall_and_panel(), 2);
  atlas.insert(tiny_view("a"));
  CHECK(atlas.gain(0) == glm::dvec3(1));
  atlas.set_gain(0, {0.5, 1e-6, 1e6});
  CHECK(atlas.gain(0) == glm::dvec3(0.5, 1e-6, 1e6));
  const Snapshot before = atlas.snapshot();
  CHECK(before.gains == std::vector<glm::dvec3>{{0.5, 1e-6, 1e6}, {1, 1, 1}});
  atlas.erase(0);
  CHECK(atlas.snapshot().gains == std::vector<glm::dvec3>(2, glm::dvec3(1)));
  atlas.insert(tiny_view("b"));
  CHECK(atlas.gain(0) == glm::dvec3(1));
  CHECK(before.gains[0] == glm::dvec3(0.5, 1e-6, 1e6));
}

TEST_CASE("slots without a view have no gain") {
  Atlas atlas(wall_and_panel(), 2);
  atlas.insert(tiny_view("a"));
  const ViewSlot slot(GENERATE(1u, 2u, 4'000'000'000u));
  const auto sentence = Catch::Message("atlas: slot " + std::to_string(slot) + " holds no view");
  CHECK_THROWS_MATCHES(atlas.set_gain(slot, {1, 1, 1}), std::logic_error, sentence);
  CHECK_THROWS_MATCHES(atlas.gain(slot), std::logic_error, sentence);
}

TEST_CASE("a gain that is no exposure is refused by slot and channel, and the old one stays") {
  Atlas atlas(wall_and_panel(), 1);
  atlas.insert(tiny_view("a"));
  atlas.set_gain(0, {2, 3, 4});
  const auto refused = [&](const glm::dvec3& gain, const std::string& sentence) {
    CHECK_THROWS_MATCHES(atlas.set_gain(0, gain), std::invalid_argument, Catch::Message(sentence));
    CHECK(atlas.gain(0) == glm::dvec3(2, 3, 4));
  };
  refused({0, 1, 1}, "atlas: gain[0] of slot 0 is 0, must be in [1e-6, 1e6]");
  refused({1, -1, 1}, "atlas: gain[1] of slot 0 is -1, must be in [1e-6, 1e6]");
  refused({1, 1, 1.5e6}, "atlas: gain[2] of slot 0 is 1500000, must be in [1e-6, 1e6]");
  refused({1, std::nan(""), 1}, "atlas: gain[1] of slot 0 is nan, must be in [1e-6, 1e6]");
  refused({1, 1, INFINITY}, "atlas: gain[2] of slot 0 is inf, must be in [1e-6, 1e6]");
}

TEST_CASE("cells once seen stay seen") {
  Atlas atlas(wall_and_panel(kCells), 1);
  const std::vector<CellPixels> first{{1, 10}}, second{{1, 1}, {3, 7}};
  atlas.mark_seen(first);
  atlas.mark_seen(second);
  CHECK(atlas.snapshot().cell_seen == std::vector<std::uint8_t>{0, 1, 0, 1, 0});
}

TEST_CASE("a snapshot does not change, and keeps alive what it shows") {
  Atlas atlas(wall_and_panel(kCells), 2);
  atlas.insert(tiny_view("a"));
  atlas.set_references(2, {0});
  const Snapshot snapshot = atlas.snapshot();
  atlas.set_references(2, {});
  atlas.erase(0);
  atlas.insert(tiny_view("b"));
  atlas.set_references(2, {0});
  atlas.set_references(3, {0});
  const std::vector<CellPixels> seen{{0, 1}};
  atlas.mark_seen(seen);
  CHECK(snapshot.views[0]->name == "a");
  CHECK(snapshot.views[1] == nullptr);
  CHECK(snapshot.references.offsets == Offsets{0, 0, 0, 1, 1, 1});
  CHECK(snapshot.references.views == Slots{0});
  CHECK(snapshot.cell_seen[0] == 0);
  CHECK(atlas.snapshot().views[0]->name == "b");
}

TEST_CASE("a snapshot's vertex colours are those of the stored views") {
  const auto surface = wall_and_panel();
  Atlas atlas(surface, 2);
  Photograph red{32, 32, {}, {}};
  for (int pixel = 0; pixel < 32 * 32; ++pixel) red.rgb.insert(red.rgb.end(), {200, 10, 20});
  const Camera camera = forward_camera(32, 32, {0, 0, -1});
  atlas.insert(traced_view(*surface, "a", camera, red, {0.05, 0, 0}));
  const std::vector<glm::u8vec3> all_red(surface->mesh.positions.size(), glm::u8vec3(200, 10, 20));
  CHECK(atlas.snapshot().vertex_colors == all_red);
  atlas.set_gain(0, {1, 1e-6, 1});
  CHECK(atlas.snapshot().vertex_colors ==
        std::vector<glm::u8vec3>(surface->mesh.positions.size(), glm::u8vec3(200, 0, 20)));
  atlas.erase(0);
  CHECK(atlas.snapshot().vertex_colors != all_red);
}

// The expected contents of an atlas, in the plainest form.
struct Ledger {
  std::map<ViewSlot, std::string> views;  // by slot
  std::vector<Slots> references{kCells};

  [[nodiscard]] bool refers_to(ViewSlot slot) const {
    return std::any_of(references.begin(), references.end(),
                       [&](const Slots& slots) { return std::find(slots.begin(), slots.end(), slot) != slots.end(); });
  }
};

void check_same(const Snapshot& snapshot, const Ledger& ledger) {
  for (ViewSlot slot{0}; slot < snapshot.views.size(); ++slot) {
    const auto found = ledger.views.find(slot);
    REQUIRE((snapshot.views[slot] != nullptr) == (found != ledger.views.end()));
    if (found != ledger.views.end()) REQUIRE(snapshot.views[slot]->name == found->second);
  }
  for (std::size_t cell = 0; cell < kCells; ++cell) {
    const auto slots = snapshot.references.of_cell(cell);
    REQUIRE(Slots(slots.begin(), slots.end()) == ledger.references[cell]);
  }
}

TEST_CASE("the books balance after any sequence of calls") {
  std::mt19937 random(7);
  Atlas atlas(wall_and_panel(kCells), 4);
  Ledger ledger;
  for (int step = 0; step < 2000; ++step) {
    const ViewSlot slot(static_cast<std::uint32_t>(random() % 4));
    switch (random() % 3) {
      case 0:
        if (ledger.views.size() < 4) {
          const std::string name = std::to_string(step);
          ledger.views[atlas.insert(tiny_view(name))] = name;
        } else {
          CHECK_THROWS_AS(atlas.insert(tiny_view("none")), std::logic_error);
        }
        break;
      case 1:
        if (ledger.views.count(slot) == 1 && !ledger.refers_to(slot)) {
          atlas.erase(slot);
          ledger.views.erase(slot);
        } else {
          CHECK_THROWS_AS(atlas.erase(slot), std::logic_error);
        }
        break;
      default: {
        const CellId cell(static_cast<std::uint32_t>(random() % kCells));
        Slots slots;
        for (const auto& [stored, name] : ledger.views) {
          if (random() % 3 == 0) slots.push_back(stored);
        }
        atlas.set_references(cell, slots);
        ledger.references[cell] = slots;
      }
    }
    REQUIRE(atlas.size() == ledger.views.size());
    check_same(atlas.snapshot(), ledger);
  }
}

TEST_CASE("under another surface, references and what was seen follow the cells") {
  Atlas atlas(wall_and_panel(kCells), 3);
  for (const char* name : {"a", "b", "c"}) atlas.insert(tiny_view(name));
  atlas.set_gain(1, {2, 3, 4});
  atlas.set_references(0, {2});
  atlas.set_references(1, {1, 0});
  atlas.set_references(4, {0});
  const std::vector<CellPixels> seen{{0, 1}, {1, 1}, {3, 1}};
  atlas.mark_seen(seen);
  const auto surface = wall_and_panel(6);
  atlas.replace_surface(surface, CellIds{4, CellId::none, 1, 3, 1, CellId::none});
  CHECK(atlas.surface() == surface);
  const std::vector<Slots> expected{{0}, {}, {1, 0}, {}, {1, 0}, {}};
  for (CellId cell{0}; cell < expected.size(); ++cell) CHECK(atlas.references(cell) == expected[cell]);
  CHECK(atlas.snapshot().cell_seen == std::vector<std::uint8_t>{0, 0, 1, 1, 1, 0});
  CHECK(atlas.size() == 3);
  CHECK(atlas.view(1)->name == "b");
  CHECK(atlas.gain(1) == glm::dvec3(2, 3, 4));
  const auto refused = [&](ViewSlot slot, const std::string& cells) {
    CHECK_THROWS_MATCHES(
        atlas.erase(slot), std::logic_error,
        Catch::Message("atlas: erase of slot " + std::to_string(slot) + ", which " + cells + " cells refer to"));
  };
  refused(0, "3");
  refused(1, "2");
  atlas.erase(2);  // the one cell that referred to it is gone
}

TEST_CASE("snapshots taken before keep the old surface alive, and nothing else does") {
  const auto surface_with = [](float z) {
    const auto surface = std::make_shared<Surface>(*wall_and_panel(kCells));
    add_wall(surface->mesh, 1, 1, 1, z);
    std::vector<CellId> cell_of_face = surface->cells.cell_of_face;
    cell_of_face.resize(surface->mesh.faces.size(), CellId(kCells));
    surface->cells = measure_cells(surface->mesh, cell_of_face, surface->cells.size);
    return surface;
  };
  std::shared_ptr<const Surface> old = wall_and_panel(kCells);
  const std::weak_ptr<const Surface> watched = old;
  Atlas atlas(std::move(old), 1);
  atlas.insert(tiny_view("a"));
  atlas.set_references(2, {0});
  {
    const Snapshot before = atlas.snapshot();
    atlas.replace_surface(surface_with(6), CellIds{0, CellId::none, CellId::none, CellId::none, CellId::none, 2});
    CHECK(before.surface == watched.lock());
    CHECK(before.references.offsets == Offsets{0, 0, 0, 1, 1, 1});
    CHECK(before.cell_seen.size() == kCells);
    const Snapshot after = atlas.snapshot();
    CHECK(after.surface == atlas.surface());
    CHECK(after.references.offsets == Offsets{0, 0, 0, 0, 0, 0, 1});
    CHECK(after.vertex_colors.size() == before.vertex_colors.size() + 4);
  }
  CHECK(watched.expired());
}

TEST_CASE("a surface that does not go with the store is refused, and the old one stays") {
  const auto surface = wall_and_panel(kCells);
  Atlas atlas(surface, 1);
  atlas.insert(tiny_view("a"));
  atlas.set_references(2, {0});
  const auto refused = [&](const std::shared_ptr<const Surface>& next, const CellIds& previous_cell,
                           const std::string& sentence) {
    CHECK_THROWS_MATCHES(atlas.replace_surface(next, previous_cell), std::invalid_argument, Catch::Message(sentence));
    CHECK(atlas.surface() == surface);
    CHECK(atlas.references(2) == Slots{0});
  };
  refused(wall_and_panel(2), {0}, "atlas: previous_cell has 1 entries, must have one per cell of the new surface, 2");
  refused(wall_and_panel(2), {0, 5}, "atlas: previous_cell[1] is 5, must be below the number of cells before, 5");
  const auto elsewhere = std::make_shared<Surface>(*wall_and_panel(1));
  elsewhere->offset.x += 1;
  refused(elsewhere, {2}, "atlas: the new surface has another offset than the one before, must have the same");
}

TEST_CASE("the books balance after any sequence of surfaces") {
  std::mt19937 random(8);
  Atlas atlas(wall_and_panel(kCells), 4);
  for (const char* name : {"a", "b", "c", "d"}) atlas.insert(tiny_view(name));
  std::vector<Slots> ledger(kCells);
  for (int step = 0; step < 500; ++step) {
    if (random() % 2 == 0) {
      const CellId cell(static_cast<std::uint32_t>(random() % ledger.size()));
      ledger[cell].clear();
      for (ViewSlot slot{0}; slot < 4; ++slot) {
        if (random() % 3 == 0) ledger[cell].push_back(slot);
      }
      atlas.set_references(cell, ledger[cell]);
    } else {
      const auto cells = static_cast<std::uint32_t>(1 + random() % 8);
      CellIds previous_cell;
      std::vector<Slots> next;
      for (CellId cell{0}; cell < cells; ++cell) {
        const bool is_new = random() % 3 == 0;
        previous_cell.push_back(is_new ? CellId::none : CellId{static_cast<std::uint32_t>(random() % ledger.size())});
        next.push_back(is_new ? Slots{} : ledger[previous_cell.back()]);
      }
      atlas.replace_surface(wall_and_panel(cells), previous_cell);
      ledger = next;
    }
    const ViewSlot slot(static_cast<std::uint32_t>(random() % 4));
    const auto refers = [&](const Slots& slots) { return std::find(slots.begin(), slots.end(), slot) != slots.end(); };
    if (std::any_of(ledger.begin(), ledger.end(), refers)) {
      CHECK_THROWS_AS(atlas.erase(slot), std::logic_error);
    } else {
      atlas.erase(slot);
      REQUIRE(atlas.insert(tiny_view("again")) == slot);
    }
    for (CellId cell{0}; cell < ledger.size(); ++cell) REQUIRE(atlas.references(cell) == ledger[cell]);
  }
}

// Every part of view `number` says which one it is.
StoredView numbered_view(std::uint32_t number) {
  StoredView view = tiny_view(std::to_string(number));
  own_mask(view).depth = std::vector<float>{static_cast<float>(number)};
  return view;
}

std::uint32_t number_of(const StoredView& view) {
  return static_cast<std::uint32_t>(view.mask->depth[0]);
}

// Replaces views one after the other, as the planner does: references away, view out, view in, references back.
void keep_replacing(Atlas& atlas, std::uint32_t changes) {
  for (std::uint32_t number = 1; number <= changes; ++number) {
    const ViewSlot slot(number % atlas.capacity());
    for (CellId cell{0}; cell < kCells; ++cell) {
      Slots slots = atlas.references(cell);
      std::erase(slots, slot);
      atlas.set_references(cell, slots);
    }
    if (atlas.view(slot)) atlas.erase(slot);
    const ViewSlot taken = atlas.insert(numbered_view(number));
    atlas.set_gain(taken, glm::dvec3(number));
    for (CellId cell{0}; cell < kCells; ++cell) {
      if (cell % 2 != number % 2) continue;
      Slots slots = atlas.references(cell);
      slots.push_back(taken);
      atlas.set_references(cell, slots);
    }
  }
}

// Checks that Catch2 cannot make on another thread.
bool is_consistent(const Snapshot& snapshot) {
  for (const ViewSlot slot : snapshot.references.views) {
    const auto& view = snapshot.views.at(slot);
    if (!view || view->name != std::to_string(number_of(*view))) return false;
    const double gain = snapshot.gains.at(slot).x;
    if (gain != 1 && gain != number_of(*view)) return false;  // 1: not set yet
  }
  return snapshot.references.offsets.size() == kCells + 1 &&
         snapshot.references.offsets.back() == snapshot.references.views.size() &&
         std::is_sorted(snapshot.references.offsets.begin(), snapshot.references.offsets.end());
}

TEST_CASE("snapshots are consistent while another thread writes") {
  Atlas atlas(wall_and_panel(kCells), 4);
  std::atomic<bool> done{false};
  std::thread writer([&] {
    keep_replacing(atlas, 20000);
    done = true;
  });
  std::size_t taken = 0, inconsistent = 0;
  std::uint32_t newest = 0;
  bool goes_back = false;
  std::vector<Snapshot> kept;
  while (!done || taken == 0) {
    Snapshot snapshot = atlas.snapshot();
    inconsistent += is_consistent(snapshot) ? 0 : 1;
    std::uint32_t latest = 0;
    for (const auto& view : snapshot.views) {
      if (view) latest = std::max(latest, number_of(*view));
    }
    goes_back = goes_back || latest + 1 < newest;  // a view is out for a moment before the next is in
    newest = std::max(newest, latest);
    if (taken++ % 64 == 0) kept.push_back(std::move(snapshot));
  }
  writer.join();
  CHECK(inconsistent == 0);
  CHECK_FALSE(goes_back);
  CHECK(std::all_of(kept.begin(), kept.end(), is_consistent));  // also after all that they show was replaced
  CHECK(atlas.size() == 4);
}

TEST_CASE("what a view shows follows its cell while another thread replaces the surface") {
  Atlas atlas(wall_and_panel(2), 2, TileOptions{});
  atlas.insert(tiny_view("a"), {{0, 1, 1}});
  atlas.insert(tiny_view("b"), {{0, 0, 1}});
  atlas.set_references(1, {0});
  std::atomic<bool> done{false};
  std::thread views([&] {
    while (!done) atlas.replace(1, tiny_view("b"), {{0, 0, 1}});
  });
  const CellIds turned{1, 0};
  for (int step = 0; step < 3000; ++step) atlas.replace_surface(wall_and_panel(2), turned);
  done = true;
  views.join();
  atlas.replace_surface(wall_and_panel(2), turned);  // an odd number of times: what was cell 1 is cell 0
  const Snapshot snapshot = atlas.snapshot();
  CHECK(snapshot.references.offsets == Offsets{0, 1, 1});
  CHECK(snapshot.views[0]);  // whose tile is resident, because it shows the cell that refers to it
}

TEST_CASE("snapshots are of one surface while another thread replaces it") {
  Atlas atlas(wall_and_panel(1), 1);
  atlas.insert(tiny_view("a"));
  std::atomic<bool> done{false};
  std::thread writer([&] {
    CellIds previous_cell;
    for (std::uint32_t step = 0; step < 5000; ++step) {
      const auto surface = std::make_shared<Surface>(*wall_and_panel(1 + step % 7));
      surface->mesh.positions.resize(surface->mesh.positions.size() + surface->cells.cells.size());
      previous_cell.assign(surface->cells.cells.size(), 0);
      atlas.replace_surface(surface, previous_cell);
      atlas.set_references(0, {0});
    }
    done = true;
  });
  std::size_t taken = 0, inconsistent = 0;
  while (!done || taken == 0) {
    const Snapshot snapshot = atlas.snapshot();
    const std::size_t cells = snapshot.surface->cells.cells.size();
    const bool fits = snapshot.references.offsets.size() == cells + 1 && snapshot.cell_seen.size() == cells &&
                      snapshot.vertex_colors.size() == snapshot.surface->mesh.positions.size();
    inconsistent += fits ? 0 : 1;
    ++taken;
  }
  writer.join();
  CHECK(inconsistent == 0);
}

}  // namespace
}  // namespace lumatlas
