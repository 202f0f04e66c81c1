// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/tile_choice.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <glm/glm.hpp>
#include <map>
#include <random>
#include <set>

#include "tests/wall_scenes.h"

namespace lumatlas {
namespace {

using Tile = std::pair<std::uint32_t, std::uint32_t>;  // view, tile

struct Store {
  explicit Store(std::size_t count, std::uint32_t references_per_cell) : surface(wall_and_panel(kCells)) {
    const auto visibility = make_ray_visibility(surface->mesh);
    for (std::size_t i = 0; i < count; ++i) {
      const double x = 0.3 * static_cast<double>(i) - 0.15 * static_cast<double>(count);
      const Camera camera = forward_camera(40, 40, {x, 0.1 * x, -0.2 * static_cast<double>(i % 3)});
      TiledView tiled = make_tiled_view("v", camera, position_photograph(40, 40), visibility->trace(camera),
                                        surface->cells, {8, 1, 0}, {});
      views.push_back(std::make_shared<const StoredView>(std::move(tiled.view)));
      shown.push_back(std::move(tiled.shown));
    }
    for (std::uint32_t cell = 0; cell < kCells; ++cell) {
      for (std::uint32_t i = 0; i < references_per_cell; ++i) references.views.push_back(i);
      references.offsets.push_back(static_cast<std::uint32_t>(references.views.size()));
    }
  }

  [[nodiscard]] std::set<Tile> all_tiles() const {
    std::set<Tile> tiles;
    for (std::uint32_t view = 0; view < shown.size(); ++view) {
      for (const ShownCell& part : shown[view]) tiles.insert({view, part.tile});
    }
    return tiles;
  }

  [[nodiscard]] double pixels(std::uint32_t view, std::uint32_t cell, const std::set<Tile>* within) const {
    double sum = 0;
    for (const ShownCell& part : shown[view]) {
      if (part.cell == cell && (!within || within->count({view, part.tile}) != 0)) sum += part.pixels;
    }
    return sum;
  }

  // What the tiles are worth, by the formula in tile_choice.h.
  [[nodiscard]] double worth(const std::set<Tile>& tiles) const {
    double sum = 0;
    for (std::uint32_t cell = 0; cell < kCells; ++cell) {
      const glm::dvec3 place = surface->cells.cells[cell].centroid;
      for (std::uint32_t asked = 0; asked < views.size(); ++asked) {
        const double weight = pixels(asked, cell, nullptr);
        if (weight == 0) continue;
        const glm::dvec3 to_asked = views[asked]->camera.center() - place;
        std::vector<double> qualities(3, 0.0);
        for (std::uint32_t by = 0; by < views.size(); ++by) {
          const double all = pixels(by, cell, nullptr);
          if (all == 0) continue;
          const glm::dvec3 to_by = views[by]->camera.center() - place;
          const double cosine = glm::dot(to_by, to_asked) / (glm::length(to_by) * glm::length(to_asked));
          const double k = std::clamp(1 - (1 - cosine) / (1 - std::cos(glm::radians(30.0))), 0.0, 1.0);
          const double resolution = std::min(1.0, glm::length(to_asked) / glm::length(to_by));
          qualities.push_back(pixels(by, cell, &tiles) / all * resolution * (0.8 * k + 0.2));
        }
        std::sort(qualities.begin(), qualities.end(), std::greater<>());
        sum += weight * (4 * qualities[0] + 2 * qualities[1] + qualities[2]) / 7;
      }
    }
    return sum;
  }

  [[nodiscard]] std::set<Tile> chosen(std::size_t count) {
    ReferenceTable table = references;
    std::set<Tile> tiles;
    for (const ViewTile& tile : choose_tiles(views, surface->cells, shown, count, table)) {
      tiles.insert({tile.view, tile.tile});
    }
    resulting = table;
    return tiles;
  }

  static constexpr std::uint32_t kCells = 9;
  std::shared_ptr<const Surface> surface;
  std::vector<std::shared_ptr<const StoredView>> views;
  std::vector<std::vector<ShownCell>> shown;
  ReferenceTable references, resulting;
};

std::set<Tile> plain_greedy(const Store& store, std::size_t count) {
  std::set<Tile> chosen;
  while (chosen.size() < count) {
    double best = -1;
    Tile choice;
    for (const Tile& tile : store.all_tiles()) {
      if (chosen.count(tile) != 0) continue;
      std::set<Tile> with = chosen;
      with.insert(tile);
      const double worth = store.worth(with);
      if (worth > best * (1 + 1e-12)) {
        best = worth;
        choice = tile;
      }
    }
    chosen.insert(choice);
  }
  return chosen;
}

TEST_CASE("the first tile chosen is worth more than any other alone, and the next ones are chosen as greedily") {
  Store store(5, 5);
  const std::set<Tile> first = store.chosen(1);
  REQUIRE(first.size() == 1);
  CHECK(store.worth(first) == Approx(store.worth(plain_greedy(store, 1))).epsilon(1e-5));
  const std::set<Tile> several = store.chosen(20);
  REQUIRE(several.size() == 20);
  CHECK(store.worth(several) >= 0.97 * store.worth(plain_greedy(store, 20)));
}

TEST_CASE("the tiles chosen are worth more than tiles by chance, and than whole views of as many tiles") {
  Store store(8, 8);
  constexpr std::size_t kCount = 60;
  const double worth = store.worth(store.chosen(kCount));
  const std::set<Tile> all = store.all_tiles();
  REQUIRE(all.size() > 2 * kCount);
  std::mt19937 random(2);
  std::vector<Tile> shuffled(all.begin(), all.end());
  for (int run = 0; run < 20; ++run) {
    std::shuffle(shuffled.begin(), shuffled.end(), random);
    CHECK(worth > store.worth({shuffled.begin(), shuffled.begin() + kCount}));
  }
  CHECK(worth > store.worth({all.begin(), std::next(all.begin(), kCount)}));
}

TEST_CASE("cells refer to views whose resident tiles show them, and to no more than before") {
  for (const std::uint32_t most : {1u, 2u, 8u}) {
    Store store(8, most);
    const std::set<Tile> tiles = store.chosen(40);
    CHECK(tiles.size() <= 40);
    REQUIRE(store.resulting.offsets.size() == Store::kCells + 1);
    for (std::uint32_t cell = 0; cell < Store::kCells; ++cell) {
      const auto views = store.resulting.of_cell(cell);
      CHECK(views.size() <= most);
      CHECK(std::is_sorted(views.begin(), views.end()));
      for (const std::uint32_t view : views) CHECK(store.pixels(view, cell, &tiles) > 0);
    }
    CHECK(!store.resulting.views.empty());
  }
}

TEST_CASE("what nobody asks for is not resident, however much room there is") {
  Store store(4, 4);
  CHECK(store.chosen(100'000).size() <= store.all_tiles().size());
  store.references.offsets.assign(Store::kCells + 1, 0);
  store.references.views.clear();
  CHECK(store.chosen(100'000).empty());
}

}  // namespace
}  // namespace lumatlas
