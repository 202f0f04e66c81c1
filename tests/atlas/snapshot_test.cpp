// SPDX-License-Identifier: GPL-3.0-or-later
// Snapshots of a store that changes, and what a snapshot must be to be drawn or written.
#include "atlas/snapshot.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <future>
#include <limits>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/colors/vertex_colors.h"
#include "mesh/visibility/visibility.h"
#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/view_parts.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

constexpr std::uint32_t kCellsOfScene = 7;
constexpr std::uint32_t kSlots = 5;
constexpr TileOptions kLayout{8, 2, 0};

std::uint32_t below(std::uint32_t end, std::mt19937& random) {
  return static_cast<std::uint32_t>(random() % end);
}

// A store, and all that was put into it, from which another store can be made that never gave a snapshot before.
struct Kept {
  explicit Kept(const TileOptions& tiles) : layout(tiles), surface(wall_and_panel(kCellsOfScene)) {
    atlas = std::make_unique<Atlas>(surface, kSlots, layout);
  }

  [[nodiscard]] TiledView random_view(std::mt19937& random) const {
    std::uniform_real_distribution<double> place(-0.6, 0.6);
    const Camera camera = oblique_camera(20 + below(20, random), 20 + below(20, random), place(random),
                                         {place(random), place(random), place(random)});
    return make_tiled_view("v", camera, position_photograph(camera.width, camera.height, below(9, random)),
                           make_ray_visibility(surface->mesh)->trace(camera), surface->cells, layout, {});
  }

  void step(std::mt19937& random) {
    const ViewSlot slot(below(kSlots, random));
    switch (below(6, random)) {
      case 0:
        if (atlas->size() < kSlots) (void)insert(random_view(random));
        break;
      case 1:
        if (atlas->view(slot)) erase(slot);
        break;
      case 2:
        if (atlas->view(slot)) {
          TiledView tiled = random_view(random);
          atlas->replace(slot, std::move(tiled.view), std::move(tiled.shown));
        }
        break;
      case 3:
        if (atlas->view(slot)) atlas->set_gain(slot, glm::dvec3(0.5 + below(10, random)));
        break;
      case 4: {
        const std::vector<CellPixels> seen{{CellId{below(kCellsOfScene, random)}, 1}};
        atlas->mark_seen(seen);
        break;
      }
      default:
        refer(CellId(below(kCellsOfScene, random)), random);
    }
  }

  ViewSlot insert(TiledView tiled) const { return atlas->insert(std::move(tiled.view), std::move(tiled.shown)); }

  void erase(ViewSlot slot) const {
    for (CellId cell{0}; cell < kCellsOfScene; ++cell) {
      std::vector<ViewSlot> slots = atlas->references(cell);
      std::erase(slots, slot);
      atlas->set_references(cell, slots);
    }
    atlas->erase(slot);
  }

  void refer(CellId cell, std::mt19937& random) const {
    std::vector<ViewSlot> slots;
    for (ViewSlot slot{0}; slot < kSlots; ++slot) {
      if (atlas->view(slot) && below(2, random) == 0) slots.push_back(slot);
    }
    atlas->set_references(cell, slots);
  }

  TileOptions layout;
  std::shared_ptr<const Surface> surface;
  std::unique_ptr<Atlas> atlas;
};

// Returns the mean from all views by the definition in vertex_colors.h.
std::vector<glm::u8vec3> mean_colors(const Atlas& atlas) {
  VertexColorMean mean(atlas.surface()->mesh);
  for (ViewSlot slot{0}; slot < atlas.capacity(); ++slot) {
    if (const auto view = atlas.view(slot)) mean.add(*view, atlas.gain(slot));
  }
  return mean.colors();
}

TEST_CASE("a snapshot of what has changed is one of the whole store") {
  const TileOptions layout = GENERATE(kWholeViews, kLayout);
  Kept kept(layout);
  std::mt19937 random(4);
  for (int step = 0; step < 300; ++step) {
    for (std::uint32_t change = below(4, random); change > 0; --change) kept.step(random);
    const Snapshot snapshot = kept.atlas->snapshot();
    CAPTURE(step);
    REQUIRE_NOTHROW(check(snapshot));
    REQUIRE(snapshot.vertex_colors == mean_colors(*kept.atlas));
    for (CellId cell{0}; cell < kCellsOfScene; ++cell) {
      std::vector<ViewSlot> expected = kept.atlas->references(cell);
      std::erase_if(expected, [&](ViewSlot slot) { return !snapshot.views[slot]; });
      const auto found = snapshot.references.of_cell(cell);
      REQUIRE(std::vector<ViewSlot>(found.begin(), found.end()) == expected);
    }
    for (ViewSlot slot{0}; slot < kSlots; ++slot) {
      if (snapshot.views[slot]) REQUIRE(snapshot.views[slot] == kept.atlas->view(slot));
      if (snapshot.views[slot]) REQUIRE(snapshot.gains[slot] == kept.atlas->gain(slot));
      if (layout.whole_views()) REQUIRE(snapshot.views[slot] == kept.atlas->view(slot));
    }
  }
}

TEST_CASE("the same tiles are resident whether snapshots were taken before or not") {
  Kept often(kLayout), once(kLayout);
  std::mt19937 random_often(9), random_once(9);
  for (int step = 0; step < 60; ++step) {
    often.step(random_often);
    once.step(random_once);
    (void)often.atlas->snapshot();
  }
  const Snapshot a = often.atlas->snapshot(), b = once.atlas->snapshot();
  REQUIRE(a.tiles.first_tile == b.tiles.first_tile);
  CHECK(a.tiles.resident_tiles() > 0);
  for (std::size_t tile = 0; tile < a.tiles.places.size(); ++tile) {
    CHECK((a.tiles.places[tile] == TilePlace::none) == (b.tiles.places[tile] == TilePlace::none));
  }
  CHECK(a.vertex_colors == b.vertex_colors);
  CHECK(a.references.views == b.references.views);
}

TEST_CASE("a view without a resident tile is not held by a snapshot") {
  Kept kept(kLayout);
  std::mt19937 random(2);
  const ViewSlot shown = kept.insert(kept.random_view(random));
  const ViewSlot idle = kept.insert(kept.random_view(random));
  for (CellId cell{0}; cell < kCellsOfScene; ++cell) kept.atlas->set_references(cell, {shown});
  kept.atlas->set_gain(idle, glm::dvec3(3));
  const Snapshot snapshot = kept.atlas->snapshot();
  CHECK(snapshot.views[shown] != nullptr);
  CHECK(snapshot.views[idle] == nullptr);
  CHECK(snapshot.gains[idle] == glm::dvec3(1));
  CHECK(snapshot.tiles.first_tile[idle] == snapshot.tiles.first_tile[idle + 1]);
  CHECK(kept.atlas->view(idle) != nullptr);  // the store has it, for when a cell refers to it
  kept.atlas->set_references(0, {shown, idle});
  CHECK(kept.atlas->snapshot().views[idle] == kept.atlas->view(idle));
}

TEST_CASE("a photograph that has left the store is freed") {
  Kept kept(kLayout);
  std::mt19937 random(2);
  const ViewSlot slot = kept.insert(kept.random_view(random));
  kept.atlas->set_references(0, {slot});
  (void)kept.atlas->snapshot();
  const std::weak_ptr<const StoredView> watched = kept.atlas->view(slot);
  kept.erase(slot);
  CHECK(watched.expired());
}

TEST_CASE("a store can be changed, and looked at, while tiles are chosen") {
  Atlas* store = nullptr;
  bool was_asked = false;
  const TilePolicy policy = [&](const TileDemand& demand) {
    was_asked = true;
    // In another thread, as a planner would: it must not have to wait for the snapshot.
    std::future<std::uint32_t> planner = std::async(std::launch::async, [&] {
      store->set_gain(0, glm::dvec3(2));
      store->set_references(0, {});
      return store->size();
    });
    REQUIRE(planner.wait_for(std::chrono::seconds(60)) == std::future_status::ready);
    CHECK(planner.get() == 1);
    return TileChoice{{}, ReferenceTable{std::vector<std::uint32_t>(demand.references.offsets.size(), 0), {}}};
  };
  const auto surface = wall_and_panel(kCellsOfScene);
  Atlas atlas(surface, 2, {8, 2, 1}, policy);
  store = &atlas;
  const Camera camera = forward_camera(40, 40);
  TiledView tiled = make_tiled_view("v", camera, position_photograph(40, 40),
                                    make_ray_visibility(surface->mesh)->trace(camera), surface->cells, {8, 2, 1}, {});
  atlas.insert(std::move(tiled.view), std::move(tiled.shown));
  for (CellId cell{0}; cell < kCellsOfScene; ++cell) atlas.set_references(cell, {0});
  const Snapshot snapshot = atlas.snapshot();
  CHECK(was_asked);
  CHECK(snapshot.gains[0] == glm::dvec3(1));  // of before
  CHECK(atlas.gain(0) == glm::dvec3(2));
}

// A store whose references need more tiles than its array has.
std::unique_ptr<Atlas> overfull(const TilePolicy& policy) {
  const TileOptions layout{8, 2, 1};
  const auto surface = wall_and_panel(kCellsOfScene);
  auto atlas = std::make_unique<Atlas>(surface, 2, layout, policy);
  const Camera camera = forward_camera(40, 40);
  TiledView tiled = make_tiled_view("v", camera, position_photograph(40, 40),
                                    make_ray_visibility(surface->mesh)->trace(camera), surface->cells, layout, {});
  atlas->insert(std::move(tiled.view), std::move(tiled.shown));
  for (CellId cell{0}; cell < kCellsOfScene; ++cell) atlas->set_references(cell, {0});
  return atlas;
}

TEST_CASE("a policy that chooses what it must not is found out, and the next snapshot is not harmed") {
  TileChoice next;
  const auto atlas = overfull([&](const TileDemand&) { return next; });
  const auto refused = [&](const TileChoice& choice, const std::string& sentence) {
    next = choice;
    CHECK_THROWS_MATCHES(atlas->snapshot(), std::logic_error, Catch::Message(sentence));
  };
  const ReferenceTable none{std::vector<std::uint32_t>(kCellsOfScene + 1, 0), {}};
  refused({{{0, 0}, {0, 1}}, none}, "atlas: its tile policy chose 2 tiles, at most 1 can be resident");
  refused({{}, {}}, "atlas: its tile policy gave references that are not those of every cell");
  ReferenceTable to_nobody = none;
  to_nobody.offsets.back() = 1;
  to_nobody.views = {1};
  refused({{}, to_nobody}, "atlas: its tile policy gave a reference to slot 1, which holds no view");
  refused({{{0, 99}}, none}, "tiles: tile 99 of slot 0 is to be resident, but there is no such tile");
  next = {{{0, 12}}, none};
  CHECK(atlas->snapshot().tiles.resident_tiles() == 1);
}

TEST_CASE("without a policy a store with too few slots says so") {
  CHECK_THROWS_MATCHES(overfull({})->snapshot(), std::logic_error,
                       Catch::Message("atlas: the references need more than the 1 tiles of its layout, and it was "
                                      "given no policy to choose by"));
}

TEST_CASE("a policy goes on from what is resident, or from nothing when that is asked for") {
  std::vector<std::size_t> resident;
  const auto atlas = overfull([&](const TileDemand& demand) {
    resident.push_back(demand.resident.size());
    return TileChoice{{{0, 12}}, demand.references};
  });
  (void)atlas->snapshot();
  (void)atlas->snapshot();
  atlas->choose_tiles_anew();
  (void)atlas->snapshot();
  (void)atlas->snapshot();
  CHECK(resident == std::vector<std::size_t>{0, 1, 0, 1});
}

TEST_CASE("a store that is cut anew is as if it had been cut so from the start") {
  const TileOptions before{8, 2, 0}, after{16, 4, 0, TexelFormat::bc7};
  const auto atlas = room_atlas(5, {}, before);
  const Snapshot as_it_was = atlas->snapshot();
  const auto visibility = make_ray_visibility(atlas->surface()->mesh);
  std::vector<SharedShownCells> shown;
  for (ViewSlot slot{0}; slot < 5; ++slot) {
    const auto view = atlas->view(slot);
    shown.push_back(std::make_shared<const std::vector<ShownCell>>(
        shown_cells(*view, visibility->trace(view->camera).face, atlas->surface()->cells, after)));
  }
  atlas->set_gain(2, glm::dvec3(0.5));
  const std::vector<SharedShownCells> shown_before = atlas->retile(after, shown);
  CHECK(atlas->layout().texels == TexelFormat::bc7);
  const Snapshot cut = atlas->snapshot(), expected = room_snapshot(5, {}, after);
  CHECK(cut.tiles.places == expected.tiles.places);
  CHECK(cut.tiles.first_tile == expected.tiles.first_tile);
  CHECK(cut.references.views == expected.references.views);
  CHECK(cut.views == as_it_was.views);
  CHECK(cut.gains[2] == glm::dvec3(0.5));
  CHECK_NOTHROW(check(as_it_was));
  CHECK_NOTHROW(check(cut));

  const auto bad = [&](const SharedShownCells& of_first) {
    std::vector<SharedShownCells> changed = shown_before;
    changed[0] = of_first;
    return changed;
  };
  const std::vector<ShownCell> no_such_tile{{10000, 0, 1}}, no_such_cell{{0, 10000, 1}};
  CHECK_THROWS_AS(atlas->retile({7, 2, 0}, shown), std::invalid_argument);
  CHECK_THROWS_AS(atlas->retile(before, bad(nullptr)), std::invalid_argument);
  for (const auto& shown_by_none : {no_such_tile, no_such_cell}) {
    CHECK_THROWS_AS(atlas->retile(before, bad(std::make_shared<const std::vector<ShownCell>>(shown_by_none))),
                    std::invalid_argument);
  }
  CHECK_THROWS_WITH(atlas->retile(before, {}),
                    Catch::Contains("atlas: shown has 0 entries, must have one per slot, 5"));
  CHECK(atlas->layout().texels == TexelFormat::bc7);
  CHECK(atlas->snapshot().tiles.places == expected.tiles.places);
  (void)atlas->retile(before, shown_before);
  CHECK(atlas->snapshot().tiles.places == as_it_was.tiles.places);
}

TEST_CASE("each rule of a snapshot is checked by name") {
  const Snapshot good = small_snapshot({}, kLayout);
  REQUIRE_NOTHROW(check(good));
  const auto refused = [&](const std::function<void(Snapshot&)>& damage, const std::string& sentence) {
    Snapshot bad = good;
    damage(bad);
    CHECK_THROWS_MATCHES(check(bad), std::invalid_argument, Catch::Message(sentence));
  };
  refused([](Snapshot& s) { s.surface = nullptr; }, "snapshot: surface is null");
  refused([](Snapshot& s) { s.gains.pop_back(); }, "snapshot: gains has 4 entries, must have one per slot of views, 5");
  refused([](Snapshot& s) { s.gains[2].y = 1e-7; },
          "snapshot: gains[2] has a channel of 1e-07, must be in [1e-6, 1e6]");
  refused([](Snapshot& s) { s.references.offsets.pop_back(); },
          "snapshot: references.offsets has 5 entries, must have one more than there are cells, 6");
  refused([](Snapshot& s) { s.references.offsets[1] = 99; },
          "snapshot: references.offsets must rise from 0 to the number of references, " +
              std::to_string(good.references.views.size()));
  refused([](Snapshot& s) { s.references.views[0] = 1; },
          "snapshot: references.views[0] is 1, must be a slot with a view");
  refused([](Snapshot& s) { s.cell_seen.clear(); }, "snapshot: cell_seen has 0 entries, must have one per cell, 5");
  refused([](Snapshot& s) { s.vertex_colors = FallbackColors::Colors(s.vertex_colors.size() - 1); },
          "snapshot: vertex_colors has " + std::to_string(good.vertex_colors.size() - 1) +
              " entries, must have one per vertex, " + std::to_string(good.vertex_colors.size()));
  refused([](Snapshot& s) { s.tiles.options.gutter_px = 3; }, "tiles: gutter_px is 3, must be 1, 2, 4 or 8");
  refused([](Snapshot& s) { s.tiles.options.tile_px = 0; },
          "snapshot: tiles.options.tile_px is 0, must be above 0 where there are tiles");
  refused([](Snapshot& s) { s.tiles.first_tile.pop_back(); },
          "snapshot: tiles.first_tile has 5 entries, must have one more than views, 6");
  refused([](Snapshot& s) { s.tiles.places.pop_back(); },
          "snapshot: tiles.places has " + std::to_string(good.tiles.places.size() - 1) +
              " entries, must have one per tile, " + std::to_string(good.tiles.places.size()));
  refused([](Snapshot& s) { s.tiles.places[0] = TilePlace{kMostTilePlaces}; },
          "snapshot: tiles.places[0] is 1073741824, must be below 1073741824 or TilePlace::none");
  refused([](Snapshot& s) { s.tiles.first_tile[1] += 1; },
          "snapshot: tiles.first_tile[1] is 7, must be 6 for the 6 tiles of slot 0");
  refused(
      [](Snapshot& s) {
        s.cell_coverage = {1, 2};
      },
      "snapshot: cell_coverage has 2 entries, must have one per cell, 5");
  refused(
      [](Snapshot& s) {
        s.cell_deviation = {0, 0, 0, 0, std::numeric_limits<float>::infinity()};
      },
      "snapshot: cell_deviation[4] is inf, must be finite and not negative");
  refused(
      [](Snapshot& s) {
        s.cell_coverage = {1, 2, -0.5f, 4, 5};
      },
      "snapshot: cell_coverage[2] is -0.5, must be finite and not negative");
  refused(
      [](Snapshot& s) {
        auto view = std::make_shared<StoredView>(*s.views[0]);
        view->photograph = std::make_shared<const StoredPhotograph>(position_photograph(8, 6));
        s.views[0] = view;
      },
      "view a.jpg: the photograph is 8x6, must be as large as its camera, 24x16");
}

TEST_CASE("each rule of a surface is checked by name") {
  const auto refused = [](const std::function<void(Surface&)>& damage, const std::string& sentence) {
    Surface surface = *wall_and_panel(kCellsOfScene);
    REQUIRE_NOTHROW(check(surface));
    damage(surface);
    CHECK_THROWS_MATCHES(check(surface), std::invalid_argument, Catch::Message(sentence));
    CHECK_THROWS_AS(Atlas(std::make_shared<Surface>(surface), 1), std::invalid_argument);
    Atlas atlas(wall_and_panel(kCellsOfScene), 1);
    const std::vector<CellId> previous_cell(kCellsOfScene, 0);
    CHECK_THROWS_AS(atlas.replace_surface(std::make_shared<Surface>(surface), previous_cell), std::invalid_argument);
  };
  refused([](Surface& s) { s.mesh.faces[3].y = 29; }, "mesh.faces[3] refers to vertex 29; it must be below 29");
  refused([](Surface& s) { s.mesh.colors.resize(3); },
          "surface: mesh.colors has 3 entries, must have one per vertex, 29, or none");
  refused([](Surface& s) { s.cells.cell_of_face.pop_back(); },
          "surface: cells.cell_of_face has 33 entries, must have one per face, 34");
  refused([](Surface& s) { s.cells.cell_of_face[2] = CellId(kCellsOfScene); },
          "surface: cells.cell_of_face[2] is 7, must be below the number of cells, 7");
  CHECK_THROWS_MATCHES(Atlas(nullptr, 1), std::invalid_argument, Catch::Message("atlas: surface is null"));
}

}  // namespace
}  // namespace lumatlas
