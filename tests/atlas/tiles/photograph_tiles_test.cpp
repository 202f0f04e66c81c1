// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>

#include "atlas/atlas.h"
#include "atlas/tiles/tiles.h"
#include "tests/support/scenes/random_stream.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

constexpr TileOptions kSmallTiles{8, 2, 0};

std::string refusal_of(const TileOptions& options) {
  try {
    check(options);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST_CASE("a tile's side and gutter must suit a texture array") {
  CHECK(refusal_of({64, 4, 0}) == "accepted");
  CHECK(refusal_of(kWholeViews) == "accepted");
  CHECK(refusal_of({1024, 8, 7}) == "accepted");
  CHECK(refusal_of({12, 4, 0}) == "tiles: tile_px is 12, must be a multiple of 8 from 8 to 1024, or 0 for whole views");
  CHECK(refusal_of({1032, 4, 0}) ==
        "tiles: tile_px is 1032, must be a multiple of 8 from 8 to 1024, or 0 for whole views");
  CHECK(refusal_of({64, 3, 0}) == "tiles: gutter_px is 3, must be 1, 2, 4 or 8");
  CHECK(refusal_of({64, 0, 0}) == "tiles: gutter_px is 0, must be 1, 2, 4 or 8");
  CHECK_THROWS_AS(TilePlaces(kWholeViews), std::invalid_argument);
}

TEST_CASE("compressed texels are of whole blocks in every level") {
  constexpr TexelFormat kBlocks = TexelFormat::bc7;
  CHECK(refusal_of({64, 1, 0, kBlocks}) == "tiles: gutter_px is 1, must be 2, 4 or 8 for texels in blocks");
  CHECK(refusal_of({24, 8, 0, kBlocks}) ==
        "tiles: tile_px is 24, must be a multiple of 16 for texels in blocks with a gutter of 8");
  for (std::uint32_t tile = 8; tile <= 1024; tile += 8) {
    for (const std::uint32_t gutter : {2u, 4u, 8u}) {
      const TileOptions options{tile, gutter, 0, kBlocks};
      if (gutter == 8 && tile % 16 != 0) continue;
      REQUIRE(refusal_of(options) == "accepted");
      REQUIRE(levels_of(options) + 1 == levels_of({tile, gutter, 0}));
      for (std::uint32_t level = 0; level < levels_of(options); ++level) {
        REQUIRE((options.place_px() >> level) % 4 == 0);
        REQUIRE((tile >> level) % 4 == 0);
      }
    }
  }
  CHECK(place_bytes({64, 4, 0, kBlocks}) == 64 * 64 / 4 + 72 * 72 + 36 * 36);
}

std::uint64_t allocated(std::uint32_t slots) {
  const PageLayout pages = pages_for(slots, 2048, 256);
  return std::uint64_t{pages.columns} * pages.rows * pages.pages;
}

TEST_CASE("the array of a budget is the largest that it holds") {
  const TileOptions options{64, 4, 0};
  const std::uint64_t slot = place_bytes(options);
  CHECK(slot == 64 * 64 / 4 + 4 * (72 * 72 + 36 * 36 + 18 * 18));
  CHECK(places_within(slot - 1, options) == 0);
  CHECK(places_within(slot, options) == 1);
  std::mt19937 random(1);
  std::uniform_int_distribution<std::uint64_t> sizes(1, 300'000);
  for (int run = 0; run < 300; ++run) {
    const std::uint64_t whole = sizes(random) * slot;
    const std::uint64_t bytes = whole + sizes(random) % slot;
    const std::uint32_t slots = places_within(bytes, options);
    REQUIRE(allocated(slots) == slots);
    REQUIRE(slots * slot <= bytes);
    REQUIRE(allocated(slots + 1) * slot > bytes);  // the next larger array that there is
  }
}

TEST_CASE("pages grow only when there would be too many") {
  for (std::uint32_t few = 1; few <= 16; ++few) CHECK(allocated(few) == few);
  CHECK(allocated(17) == 32);
  CHECK(pages_for(5, 2048, 4).columns == 4);
  const PageLayout many = pages_for(16 * 2048 + 1, 2048, 256);
  CHECK(many.columns == 8);
  CHECK(many.pages == 513);
  CHECK(pages_for(1u << 30, 2048, 20).columns == 16);  // 32 would be beyond the texture's side
}

// Finds by definition every usable pixel of every tile and its gutter.
std::vector<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> shown_by_definition(
    const StoredView& view, const std::vector<FaceId>& face, const Cells& cells, const TileOptions& options) {
  const auto width = static_cast<int>(view.camera.width);
  const auto height = static_cast<int>(view.camera.height);
  const auto size = static_cast<int>(options.tile_px);
  const auto gutter = static_cast<int>(options.gutter_px);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> counts;
  std::uint32_t tile = 0;
  for (int top = 0; top < height; top += size) {
    for (int left = 0; left < width; left += size, ++tile) {
      for (int y = std::max(0, top - gutter); y < std::min(height, top + size + gutter); ++y) {
        for (int x = std::max(0, left - gutter); x < std::min(width, left + size + gutter); ++x) {
          const auto pixel = static_cast<std::size_t>(y) * view.camera.width + static_cast<std::size_t>(x);
          if (view.mask->validity[pixel] == 0) continue;
          const bool inside = x >= left && x < left + size && y >= top && y < top + size;
          counts[{tile, cells.cell_of_face[face[pixel]]}] += inside ? 1 : 0;
        }
      }
    }
  }
  std::vector<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> shown;
  for (const auto& [key, pixels] : counts) shown.emplace_back(key.first, key.second, pixels);
  return shown;
}

TEST_CASE("a tile shows the cells of the usable pixels in it and in its gutter") {
  const auto surface = wall_and_panel(5);
  const auto visibility = make_ray_visibility(surface->mesh);
  for (const TileOptions& options : {TileOptions{8, 1, 0}, TileOptions{8, 8, 0}, TileOptions{16, 4, 0}}) {
    const Camera camera = oblique_camera(50, 37, 0.1, {0.1, 0.2, -0.3});
    const VisibilityBuffer visible = visibility->trace(camera);
    const TiledView tiled =
        make_tiled_view("a", camera, position_photograph(50, 37), visible, surface->cells, options, {});
    std::vector<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> shown;
    for (const ShownCell& part : tiled.shown) shown.emplace_back(part.tile, part.cell, part.pixels);
    REQUIRE(shown.size() > 10);
    CHECK((shown == shown_by_definition(tiled.view, visible.face, surface->cells, options)));
  }
  const Camera camera = forward_camera(16, 16);
  CHECK(make_tiled_view("a", camera, position_photograph(16, 16), visibility->trace(camera), surface->cells,
                        kWholeViews, {})
            .shown.empty());
}

TEST_CASE("resident pixels are those of resident tiles and their gutters") {
  Camera camera = forward_camera(20, 17);
  TileTable table;
  table.options = kSmallTiles;  // 3 x 3 tiles of 8
  table.first_tile = {0, 9};
  table.places.assign(9, TilePlace::none);
  table.places[4] = 3;  // x 8..16, y 8..16
  table.places[8] = 0;  // x 16..20, y 16..17
  CHECK(table.resident_tiles() == 2);
  CHECK(table.places_needed() == 4);
  const std::vector<std::uint8_t> mask = table.resident_pixels(0, camera);
  for (std::uint32_t y = 0; y < 17; ++y) {
    for (std::uint32_t x = 0; x < 20; ++x) {
      const bool middle = x >= 6 && x < 18 && y >= 6 && y < 18;
      const bool last = x >= 14 && y >= 14;
      INFO("pixel " << x << ", " << y);
      REQUIRE((mask[20 * y + x] != 0) == (middle || last));
      REQUIRE(table.resident(0, camera, x + 0.99, y + 0.01) == ((x / 8 == 1 && y / 8 == 1) || (x >= 16 && y >= 16)));
    }
  }
}

TEST_CASE("tiles that stay keep their slots, others give theirs back, and none is used twice") {
  constexpr std::uint32_t kViews = 6, kTiles = 20, kMost = 25;
  TilePlaces slots({8, 1, kMost});
  std::mt19937 random(5);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> before;
  std::vector<std::uint32_t> tiles_of_view(kViews, kTiles);
  for (int step = 0; step < 300; ++step) {
    tiles_of_view[below(kViews, random)] = below(3, random) == 0 ? 0 : kTiles;
    std::set<std::pair<std::uint32_t, std::uint32_t>> wanted;
    for (const auto& [tile, slot] : before) {
      if (below(4, random) != 0 && tiles_of_view[tile.first] > 0) wanted.insert(tile);
    }
    for (std::uint32_t more = below(8, random); more > 0 && wanted.size() < kMost; --more) {
      const std::uint32_t view = below(kViews, random);
      if (tiles_of_view[view] > 0) wanted.insert({view, below(kTiles, random)});
    }
    std::vector<ViewTile> tiles;
    for (const auto& [view, tile] : wanted) tiles.push_back({ViewSlot{view}, tile});
    slots.assign(tiles, tiles_of_view);
    const TileTable& table = slots.table();
    REQUIRE(table.resident_tiles() == wanted.size());
    REQUIRE(table.places_needed() <= kMost);
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> now;
    std::set<std::uint32_t> used;
    for (const auto& tile : wanted) {
      const std::uint32_t slot = table.places[table.first_tile[tile.first] + tile.second];
      REQUIRE(slot < kMost);
      REQUIRE(used.insert(slot).second);
      if (before.count(tile) != 0) REQUIRE(before[tile] == slot);
      now[tile] = slot;
    }
    before = now;
  }
  const std::vector<ViewTile> too_many(kMost + 1, ViewTile{0, 0});
  CHECK_THROWS_AS(slots.assign(too_many, tiles_of_view), std::logic_error);
}

TEST_CASE("each rule of cutting views into tiles is checked by name") {
  CHECK_THROWS_MATCHES(TileGrid(8, 8, 0), std::invalid_argument,
                       Catch::Message("tiles: tile_px is 0, must be above 0 to cut an image"));
  CHECK_THROWS_MATCHES(places_within(1000, kWholeViews), std::invalid_argument,
                       Catch::Message("tiles: tile_px is 0, must be above 0, for whole views have no places"));
  CHECK_THROWS_MATCHES(pages_for(1, 0, 1), std::invalid_argument,
                       Catch::Message("tiles: most_pages is 0, must be at least 1"));
  CHECK_THROWS_MATCHES(pages_for(1, 1, 0), std::invalid_argument,
                       Catch::Message("tiles: most_columns is 0, must be at least 1"));
  const auto surface = wall_and_panel(3);
  const Camera camera = forward_camera(9, 9);
  const StoredView view = traced_view(*surface, "a", camera, position_photograph(9, 9));
  std::vector<FaceId> face = make_ray_visibility(surface->mesh)->trace(camera).face;
  face[40] = 34;
  CHECK_THROWS_MATCHES(shown_cells(view, face, surface->cells, kSmallTiles), std::invalid_argument,
                       Catch::Message("tiles: view a shows face 34, the mesh has 34"));
  face.pop_back();
  CHECK_THROWS_MATCHES(shown_cells(view, face, surface->cells, kSmallTiles), std::invalid_argument,
                       Catch::Message("tiles: view a: face has 80 values, must have one per pixel, 81"));
  CHECK_THROWS_AS(shown_cells(view, face, surface->cells, {8, 3, 0}), std::invalid_argument);
  TilePlaces slots({8, 1, 9});
  const std::vector<std::uint32_t> tiles_of_view{4, 0};
  const std::vector<ViewTile> beyond{{0, 4}}, free{{1, 0}}, nowhere{{2, 0}};
  for (const auto& tiles : {beyond, free, nowhere})
    CHECK_THROWS_AS(slots.assign(tiles, tiles_of_view), std::logic_error);
}

TEST_CASE("tiles follow their cells when these are numbered anew") {
  RandomStream stream({8, 2, 0});
  std::mt19937 random(3);
  for (int step = 0; step < 8; ++step) stream.step(random);
  const std::uint32_t before = stream.atlas.snapshot().tiles.resident_tiles();
  const auto turned = std::make_shared<Surface>(*stream.surface);
  std::vector<CellId> previous_cell;
  for (CellId cell{0}; cell < 9; ++cell) previous_cell.emplace_back(8 - cell);
  for (CellId& cell : turned->cells.cell_of_face) cell = CellId(8 - cell);
  turned->cells = measure_cells(turned->mesh, turned->cells.cell_of_face, turned->cells.size);
  stream.atlas.replace_surface(turned, previous_cell);
  CHECK(stream.atlas.snapshot().tiles.resident_tiles() == before);
  stream.atlas.replace_surface(stream.surface, std::vector<CellId>(9, CellId::none));
  CHECK(stream.atlas.snapshot().tiles.resident_tiles() == 0);  // no cell is known to be shown anywhere
}

}  // namespace
}  // namespace lumatlas
