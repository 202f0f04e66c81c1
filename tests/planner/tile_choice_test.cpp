// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/tile_choice.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <glm/glm.hpp>
#include <map>
#include <random>
#include <set>
#include <stdexcept>

#include "atlas/atlas.h"
#include "tests/support/scenes/random_stream.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

using Tile = std::pair<std::uint32_t, std::uint32_t>;  // view, tile

struct TileStore {
  TileStore(std::size_t count, std::uint32_t references_per_cell)
      : TileStore(row_of_cameras(count), references_per_cell) {}

  TileStore(const std::vector<Camera>& cameras, std::uint32_t references_per_cell) : surface(wall_and_panel(kCells)) {
    const auto visibility = make_ray_visibility(surface->mesh);
    for (const Camera& camera : cameras) {
      TiledView tiled = make_tiled_view("v", camera, position_photograph(camera.width, camera.height),
                                        visibility->trace(camera), surface->cells, {8, 1, 0}, {});
      views.push_back(std::make_shared<const StoredView>(std::move(tiled.view)));
      shown.push_back(std::make_shared<const std::vector<ShownCell>>(std::move(tiled.shown)));
    }
    for (CellId cell{0}; cell < kCells; ++cell) {
      for (std::uint32_t i = 0; i < references_per_cell; ++i) references.views.emplace_back(i);
      references.offsets.push_back(static_cast<std::uint32_t>(references.views.size()));
    }
  }

  [[nodiscard]] static std::vector<Camera> row_of_cameras(std::size_t count) {
    std::vector<Camera> cameras;
    for (std::size_t i = 0; i < count; ++i) {
      const double x = 0.3 * static_cast<double>(i) - 0.15 * static_cast<double>(count);
      cameras.push_back(forward_camera(40, 40, {x, 0.1 * x, -0.2 * static_cast<double>(i % 3)}));
    }
    return cameras;
  }

  // With a cell in the tile itself: what is in a gutter alone, a neighbour holds.
  [[nodiscard]] std::set<Tile> tiles_of(std::uint32_t view) const {
    std::set<Tile> tiles;
    for (const ShownCell& part : *shown[view]) {
      if (part.pixels > 0) tiles.insert({view, part.tile});
    }
    return tiles;
  }

  [[nodiscard]] std::set<Tile> all_tiles() const {
    std::set<Tile> tiles;
    for (std::uint32_t view = 0; view < shown.size(); ++view) tiles.merge(tiles_of(view));
    return tiles;
  }

  [[nodiscard]] double pixels(std::uint32_t view, CellId cell, const std::set<Tile>* within) const {
    double sum = 0;
    for (const ShownCell& part : *shown[view]) {
      if (part.cell == cell && (!within || within->count({view, part.tile}) != 0)) sum += part.pixels;
    }
    return sum;
  }

  // Returns the value of the tiles by the formula in tile_choice.h.
  [[nodiscard]] double worth(const std::set<Tile>& tiles) const {
    double sum = 0;
    for (CellId cell{0}; cell < kCells; ++cell) {
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
          const double resolution = std::min(
              1.0, views[by]->camera.fx / glm::length(to_by) / (views[asked]->camera.fx / glm::length(to_asked)));
          qualities.push_back(pixels(by, cell, &tiles) / all * resolution * (0.8 * k + 0.2));
        }
        std::sort(qualities.begin(), qualities.end(), std::greater<>());
        sum += weight * (4 * qualities[0] + 2 * qualities[1] + qualities[2]) / 7;
      }
    }
    return sum;
  }

  // Goes on from `resident`, if that is not empty.
  [[nodiscard]] std::set<Tile> chosen(std::size_t count, const std::set<Tile>& resident = {}) {
    std::vector<ViewTile> before;
    for (const auto& [view, tile] : resident) before.push_back({ViewSlot{view}, tile});
    const TileChoice choice = choose_tiles({*surface, views, shown, references, count, before});
    std::set<Tile> tiles;
    for (const ViewTile& tile : choice.tiles) tiles.insert({tile.view, tile.tile});
    resulting = choice.references;
    return tiles;
  }

  static constexpr std::uint32_t kCells = 9;
  std::shared_ptr<const Surface> surface;
  std::vector<std::shared_ptr<const StoredView>> views;
  std::vector<SharedShownCells> shown;
  ReferenceTable references, resulting;
};

std::set<Tile> greedy_tiles(const TileStore& store, std::size_t count) {
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

std::set<Tile> united(std::set<Tile> a, const std::set<Tile>& b) {
  a.insert(b.begin(), b.end());
  return a;
}

// Whole views one after the other, each time the one that is worth most per tile, until it does not fit.
std::set<Tile> whole_views(const TileStore& store, std::size_t count) {
  std::set<Tile> chosen;
  std::set<std::uint32_t> left;
  for (std::uint32_t view = 0; view < store.views.size(); ++view) left.insert(view);
  double worth = 0;
  while (!left.empty()) {
    double best = -1;
    std::uint32_t choice = 0;
    for (const std::uint32_t view : left) {
      const std::set<Tile> tiles = store.tiles_of(view);
      if (tiles.empty()) continue;
      const double gain = (store.worth(united(chosen, tiles)) - worth) / static_cast<double>(tiles.size());
      if (gain > best) {
        best = gain;
        choice = view;
      }
    }
    if (best < 0 || chosen.size() + store.tiles_of(choice).size() > count) break;
    chosen = united(chosen, store.tiles_of(choice));
    worth = store.worth(chosen);
    left.erase(choice);
  }
  return chosen;
}

// Returns cameras of different sizes, at different distances.
std::vector<Camera> random_cameras(std::size_t count, std::mt19937& random, std::uint32_t most_px = 40) {
  std::uniform_real_distribution<double> aside(-1, 1), back(-1.5, 0);
  std::uniform_int_distribution<std::uint32_t> size(12, most_px);
  std::vector<Camera> cameras;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = aside(random), y = aside(random), z = back(random);
    const std::uint32_t width = size(random), height = size(random);
    cameras.push_back(forward_camera(width, height, {x, y, z}));
  }
  return cameras;
}

TEST_CASE("the tiles chosen are worth no less than whole views chosen as greedily, whatever the budget") {
  std::mt19937 random(5);
  for (int scene = 0; scene < 25; ++scene) {
    TileStore store(random_cameras(6, random), 6);
    const std::size_t all = store.all_tiles().size();
    const std::size_t count = std::uniform_int_distribution<std::size_t>(1, all)(random);
    CAPTURE(scene, count, all);
    const std::set<Tile> whole = whole_views(store, count);
    const std::set<Tile> chosen = store.chosen(count);
    CHECK(chosen.size() <= count);
    CHECK(store.worth(chosen) >= store.worth(whole) * (1 - 1e-5));
    if (!whole.empty()) {  // with room for just these
      CHECK(store.chosen(whole.size()).size() <= whole.size());
      CHECK(store.worth(store.chosen(whole.size())) >= store.worth(whole) * (1 - 1e-5));
    }
  }
}

TEST_CASE("where there is room for all tiles that show something, all are chosen") {
  std::mt19937 random(6);
  for (int scene = 0; scene < 5; ++scene) {
    TileStore store(random_cameras(5, random), 5);
    const std::set<Tile> all = store.all_tiles();
    CHECK(store.chosen(all.size()) == all);
    CHECK(store.chosen(all.size() + 100) == all);
  }
}

// The four steps of tile_choice.h, each value worked out at every step, by the formula alone.
class BruteForce {
 public:
  BruteForce(const TileStore& store, std::size_t count) : store_(store), count_(count) {}

  [[nodiscard]] double worth() {
    take_whole_views(count_);
    const std::set<Tile> fitting = chosen_;
    take_whole_views(static_cast<std::size_t>(1.2 * static_cast<double>(count_)));
    while (chosen_.size() > count_) take_or_give_up(chosen_);
    fill();
    const double trimmed = store_.worth(chosen_);
    chosen_ = fitting;
    fill();
    return std::max(trimmed, store_.worth(chosen_));
  }

 private:
  void take_whole_views(std::size_t count) {
    while (true) {
      const double worth = store_.worth(chosen_);
      double best = 0;
      std::set<Tile> choice;
      for (std::uint32_t view = 0; view < store_.views.size(); ++view) {
        const std::set<Tile> tiles = store_.tiles_of(view);
        if (tiles.empty() || chosen_.count(*tiles.begin()) != 0) continue;
        const double gain = (store_.worth(united(chosen_, tiles)) - worth) / static_cast<double>(tiles.size());
        if (gain > best * (1 + 1e-6)) {
          best = gain;
          choice = tiles;
        }
      }
      if (choice.empty() || chosen_.size() + choice.size() > count) return;
      chosen_ = united(chosen_, choice);
    }
  }

  // The one of these tiles that leaves most when it changes sides.
  double take_or_give_up(const std::set<Tile>& tiles) {
    double best = -1;
    std::set<Tile> choice;
    for (const Tile& tile : tiles) {
      std::set<Tile> changed = chosen_;
      if (changed.erase(tile) == 0) changed.insert(tile);
      const double worth = store_.worth(changed);
      if (worth > best * (1 + 1e-6)) {
        best = worth;
        choice = changed;
      }
    }
    chosen_ = choice;
    return best;
  }

  void fill() {
    while (chosen_.size() < count_) {
      std::set<Tile> others;
      for (const Tile& tile : store_.all_tiles()) {
        if (chosen_.count(tile) == 0) others.insert(tile);
      }
      const std::set<Tile> before = chosen_;
      const double worth = store_.worth(chosen_);
      if (!others.empty() && take_or_give_up(others) > worth * (1 + 1e-9)) continue;
      chosen_ = before;
      return;
    }
  }

  const TileStore& store_;
  std::size_t count_;
  std::set<Tile> chosen_;
};

TEST_CASE("tiles are chosen as if every value were worked out at every step") {
  std::mt19937 random(11);
  for (int scene = 0; scene < 8; ++scene) {
    TileStore store(random_cameras(4, random, 22), 4);
    const std::size_t all = store.all_tiles().size();
    const std::size_t count = std::uniform_int_distribution<std::size_t>(2, all)(random);
    CAPTURE(scene, count, all);
    // Single precision breaks ties in another way than the test's double.
    CHECK(store.worth(store.chosen(count)) == Approx(BruteForce(store, count).worth()).epsilon(2e-3));
  }
}

// Returns the value of the best of all choices of `count` tiles.
double most_worth(const TileStore& store, std::size_t count) {
  const std::set<Tile> all = store.all_tiles();
  const std::vector<Tile> tiles(all.begin(), all.end());
  std::vector<bool> taken(tiles.size(), false);
  std::fill_n(taken.begin(), count, true);
  double most = 0;
  do {
    std::set<Tile> some;
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      if (taken[i]) some.insert(tiles[i]);
    }
    most = std::max(most, store.worth(some));
  } while (std::prev_permutation(taken.begin(), taken.end()));
  return most;
}

TEST_CASE("on small scenes the tiles chosen are worth nearly as much as the best of all choices") {
  constexpr std::size_t kMostTiles = 14;
  std::mt19937 random(13);
  int compared = 0;
  double worst = 1, sum = 0;
  while (compared < 12) {
    TileStore store(random_cameras(3, random, 20), 3);
    const std::size_t all = store.all_tiles().size();
    if (all < 6 || all > kMostTiles) continue;
    const std::size_t count = std::uniform_int_distribution<std::size_t>(2, all - 2)(random);
    const double share = store.worth(store.chosen(count)) / most_worth(store, count);
    CAPTURE(all, count, share);
    CHECK(share <= 1 + 1e-9);
    worst = std::min(worst, share);
    sum += share;
    ++compared;
  }
  CAPTURE(worst, sum / compared);
  CHECK(worst > 0.8);
  CHECK(sum / compared > 0.97);
}

TEST_CASE("a choice that is brought up to date keeps within its budget and comes close to one from all") {
  std::mt19937 random(12);
  double kept_worth = 0, fresh_worth = 0;
  for (int scene = 0; scene < 10; ++scene) {
    const std::vector<Camera> cameras = random_cameras(8, random);
    TileStore before({cameras.begin(), cameras.end() - 1}, 7), now(cameras, 8);
    const std::size_t count = now.all_tiles().size() / 3;
    const std::set<Tile> resident = before.chosen(count);
    const std::set<Tile> updated = now.chosen(count, resident);
    CAPTURE(scene, count);
    CHECK(updated.size() <= count);
    CHECK(now.worth(updated) >= now.worth(resident) * (1 - 1e-5));
    std::size_t stayed = 0;
    for (const Tile& tile : resident) stayed += updated.count(tile);
    CHECK(stayed * 10 >= resident.size() * 8);  // what a renderer has need not be copied again
    kept_worth += now.worth(updated);
    fresh_worth += now.worth(now.chosen(count));
  }
  CHECK(kept_worth >= 0.93 * fresh_worth);
}

TEST_CASE("what is resident and asked for again stays as it is") {
  TileStore store(6, 6);
  std::set<Tile> tiles = store.chosen(40);
  for (int again = 0; again < 6; ++again) tiles = store.chosen(40, tiles);  // exchanges come to an end
  CHECK(store.chosen(40, tiles) == tiles);
}

TEST_CASE("a demand whose parts do not belong together is refused") {
  TileStore store(2, 2);
  const std::vector<SharedShownCells> too_few(1, store.shown[0]);
  CHECK_THROWS_MATCHES(choose_tiles({*store.surface, store.views, too_few, store.references, 9, {}}),
                       std::invalid_argument,
                       Catch::Message("tile choice: shown is of 1 slots, must be of as many as there are views, 2"));
  const ReferenceTable none;
  CHECK_THROWS_MATCHES(
      choose_tiles({*store.surface, store.views, store.shown, none, 9, {}}), std::invalid_argument,
      Catch::Message("tile choice: references are of 0 cells, must be of as many as the surface has, 9"));
  std::vector<SharedShownCells> shown = store.shown;
  shown[1] = nullptr;
  CHECK_THROWS_MATCHES(choose_tiles({*store.surface, store.views, shown, store.references, 9, {}}),
                       std::invalid_argument,
                       Catch::Message("tile choice: slot 1 has no list of shown cells, must have one, empty or not"));
  shown[1] = std::make_shared<const std::vector<ShownCell>>(std::vector<ShownCell>{{0, 9, 1}});
  CHECK_THROWS_MATCHES(choose_tiles({*store.surface, store.views, shown, store.references, 9, {}}),
                       std::invalid_argument, Catch::Message("tile choice: slot 1 shows cell 9, must be below 9"));
  store.views[1] = nullptr;
  CHECK_THROWS_MATCHES(choose_tiles({*store.surface, store.views, store.shown, store.references, 9, {}}),
                       std::invalid_argument, Catch::Message("tile choice: slot 1 shows cells, but holds no view"));
}

TEST_CASE("the first tile chosen is worth more than any other alone, and the next ones are chosen as greedily") {
  TileStore store(5, 5);
  const std::set<Tile> first = store.chosen(1);
  REQUIRE(first.size() == 1);
  CHECK(store.worth(first) == Approx(store.worth(greedy_tiles(store, 1))).epsilon(1e-5));
  const std::set<Tile> several = store.chosen(20);
  REQUIRE(several.size() == 20);
  CHECK(store.worth(several) >= 0.97 * store.worth(greedy_tiles(store, 20)));
}

TEST_CASE("the tiles chosen are worth more than tiles by chance, and than whole views of as many tiles") {
  TileStore store(8, 8);
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

TEST_CASE("cells refer to the views whose resident tiles show them, and to no more than before") {
  for (const std::uint32_t most : {1u, 2u, 8u}) {
    TileStore store(8, most);
    const std::set<Tile> tiles = store.chosen(40);
    CHECK(tiles.size() <= 40);
    REQUIRE(store.resulting.offsets.size() == TileStore::kCells + 1);
    for (CellId cell{0}; cell < TileStore::kCells; ++cell) {
      const auto views = store.resulting.of_cell(cell);
      CHECK(views.size() <= most);
      CHECK(std::is_sorted(views.begin(), views.end()));
      for (const std::uint32_t view : views) CHECK(store.pixels(view, cell, &tiles) > 0);
      std::size_t resident = 0;
      for (std::uint32_t view = 0; view < store.views.size(); ++view) {
        if (store.pixels(view, cell, &tiles) > 0) ++resident;
      }
      CHECK(views.size() == std::min<std::size_t>(most, resident));
    }
    CHECK(!store.resulting.views.empty());
  }
}

TEST_CASE("tiles that no reference needs are not resident, whatever the capacity") {
  TileStore store(4, 4);
  CHECK(store.chosen(100'000).size() <= store.all_tiles().size());
  store.references.offsets.assign(TileStore::kCells + 1, 0);
  store.references.views.clear();
  CHECK(store.chosen(100'000).empty());
}

TEST_CASE("a store never has more tiles resident than its array, and refers to none that is not") {
  for (const std::uint32_t most : {1u, 7u, 40u}) {
    RandomStream stream({8, 2, most}, choose_tiles);
    std::mt19937 random(most);
    bool was_full = false;
    for (int step = 0; step < 60; ++step) {
      stream.step(random);
      const Snapshot snapshot = stream.atlas.snapshot();
      const TileTable& tiles = snapshot.tiles;
      REQUIRE(tiles.resident_tiles() <= most);
      REQUIRE(tiles.places_needed() <= most);
      was_full |= tiles.resident_tiles() == most;
      for (CellId cell{0}; cell < 9; ++cell) {
        REQUIRE(snapshot.references.of_cell(cell).size() <= stream.atlas.references(cell).size());
        for (const std::uint32_t view : snapshot.references.of_cell(cell)) {
          REQUIRE(snapshot.views[view]);
          const auto first = tiles.places.begin() + tiles.first_tile[view];
          REQUIRE(std::any_of(first, tiles.places.begin() + tiles.first_tile[view + 1],
                              [](TilePlace slot) { return slot != TilePlace::none; }));
        }
      }
    }
    CHECK(was_full);
  }
}

}  // namespace
}  // namespace lumatlas
