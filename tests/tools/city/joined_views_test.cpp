// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/joining/joined_views.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace lumatlas {

namespace {

constexpr std::uint32_t kSide = 16, kTile = 8, kGutter = 1;

// A view of two by two tiles, of one colour, that sees a plane at `depth`, with some tiles resident.
Snapshot part_with(const std::string& name, std::uint8_t color, float depth, const std::vector<int>& resident) {
  Photograph photograph;
  photograph.width = photograph.height = kSide;
  photograph.rgb.assign(3 * kSide * kSide, color);
  auto mask = std::make_shared<ViewMask>();
  mask->depth = std::vector<float>(kSide * kSide, depth);
  mask->validity = std::vector<std::uint8_t>(kSide * kSide, color);
  Snapshot part;
  part.views.push_back(std::make_shared<const StoredView>(
      StoredView{name, centered_camera(kSide, kSide, 10), std::make_shared<const StoredPhotograph>(photograph), mask}));
  part.gains.emplace_back(1.0);
  part.tiles.options = {kTile, kGutter, 0, TexelFormat::rgb8};
  part.tiles.first_tile = {0, 4};
  std::uint32_t next = 0;
  for (const int there : resident) part.tiles.places.push_back(there != 0 ? TilePlace(next++) : TilePlace::none);
  return part;
}

std::size_t pixel_at(std::uint32_t x, std::uint32_t y) {
  return std::size_t{y} * kSide + x;
}

}  // namespace

TEST_CASE("A photograph in several parts becomes one view with the tiles of all", "[joined_views]") {
  JoinedViews views;
  const Snapshot first = part_with("b", 50, 2, {1, 0, 0, 0}), second = part_with("b", 50, 2, {0, 0, 0, 1}),
                 other = part_with("a", 90, 3, {0, 1, 0, 0});
  for (const Snapshot* part : {&first, &second, &other}) views.add(*part);
  Snapshot joined;
  views.fill(joined);
  REQUIRE(joined.views.size() == 2);
  CHECK(joined.views[0]->name == "a");
  CHECK(joined.views[1]->name == "b");
  CHECK(views.slots_of(first) == std::vector<ViewSlot>{ViewSlot(1)});
  CHECK(views.slots_of(other) == std::vector<ViewSlot>{ViewSlot(0)});
  CHECK(joined.tiles.first_tile == std::vector<std::uint32_t>{0, 4, 8});
  CHECK(joined.tiles.resident_tiles() == 3);
  CHECK(joined.tiles.places[1] == TilePlace(0));
  CHECK(joined.tiles.places[4] == TilePlace(1));
  CHECK(joined.tiles.places[7] == TilePlace(2));
  const StoredView& view = *joined.views[1];
  CHECK(view.photograph->color(pixel_at(3, 3))[0] == 50);
  CHECK(view.photograph->color(pixel_at(12, 12))[0] == 50);
  CHECK(view.photograph->color(pixel_at(12, 3))[0] == 0);  // its tile is in no part
  CHECK(view.mask->validity[pixel_at(12, 12)] == 50);
  CHECK(view.mask->validity[pixel_at(12, 3)] == 0);
  CHECK(std::isinf(view.mask->depth[pixel_at(3, 12)]));
}

TEST_CASE("What stands before all else in any part is what a joined view sees", "[joined_views]") {
  JoinedViews views;
  // The first part lacks a surface that stands before its own; both have the first tile.
  views.add(part_with("a", 50, 4, {1, 1, 0, 0}));
  views.add(part_with("a", 80, 2, {1, 0, 0, 0}));
  views.add(part_with("a", 50, 5, {1, 0, 0, 0}));
  Snapshot joined;
  views.fill(joined);
  const ViewMask& mask = *joined.views[0]->mask;
  CHECK(mask.depth[pixel_at(3, 3)] == 2);
  CHECK(mask.validity[pixel_at(3, 3)] == 80);
  CHECK(mask.depth[pixel_at(12, 3)] == 4);
}

TEST_CASE("Views that are not of one photograph are not joined", "[joined_views]") {
  JoinedViews views;
  views.add(part_with("a", 50, 4, {1, 1, 0, 0}));
  Snapshot moved = part_with("a", 50, 4, {0, 1, 0, 0});
  StoredView view = *moved.views[0];
  view.camera.cam_from_world_translation.x = 1;
  moved.views[0] = std::make_shared<const StoredView>(view);
  CHECK_THROWS_AS(views.add(moved), std::invalid_argument);
  Snapshot coarser = part_with("c", 50, 4, {0, 1, 0, 0});
  coarser.tiles.options.tile_px = 16;
  CHECK_THROWS_AS(views.add(coarser), std::invalid_argument);
}

}  // namespace lumatlas
