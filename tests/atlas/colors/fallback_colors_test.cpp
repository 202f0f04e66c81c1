// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/colors/fallback_colors.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <memory>
#include <random>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/colors/vertex_colors.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

using ColorList = FallbackColors::Colors;

// Returns the colours of a snapshot by their definition; the views are whole.
ColorList defined_colors(const Snapshot& snapshot) {
  VertexColorMean mean(snapshot.surface->mesh);
  for (std::size_t slot = 0; slot < snapshot.views.size(); ++slot) {
    if (snapshot.views[slot]) mean.add(*snapshot.views[slot], snapshot.gains[slot]);
  }
  return mean.colors();
}

// A store that changes at random: views come, go, move, and have other gains.
class ColoredStore {
 public:
  ColoredStore() : surface_(wall_and_panel(5)), atlas_(surface_, 5) {}

  Snapshot next() {
    const ViewSlot slot(static_cast<std::uint32_t>(random_() % atlas_.capacity()));
    const Camera camera = forward_camera(24, 16, {0.05 * static_cast<double>(random_() % 9), 0, -0.5});
    if (!atlas_.view(slot)) {
      atlas_.insert_at(slot, traced_view(*surface_, "a", camera,
                                         position_photograph(24, 16, static_cast<std::uint32_t>(random_() % 3))));
    } else if (random_() % 4 == 0) {
      atlas_.erase(slot);
    } else if (random_() % 2 == 0) {
      atlas_.set_poses(std::vector<ViewPose>{{slot, camera}});
    } else {
      atlas_.set_gain(slot, {1 + 0.1 * static_cast<double>(random_() % 9), 1, 1});
    }
    return atlas_.snapshot();
  }

 private:
  std::mt19937 random_{4};
  std::shared_ptr<const Surface> surface_;
  Atlas atlas_;
};

TEST_CASE("given colours are there at once") {
  const ColorList list{{1, 2, 3}, {4, 5, 6}};
  const FallbackColors colors = list;
  CHECK(colors.are_made());
  CHECK(colors.size() == 2);
  CHECK(colors.get() == list);
  CHECK(colors == FallbackColors(list));
  CHECK_FALSE(colors == FallbackColors(ColorList{{1, 2, 3}, {4, 5, 7}}));
  CHECK(FallbackColors().size() == 0);
  CHECK(first_of(colors, 1).get() == ColorList{{1, 2, 3}});
}

TEST_CASE("colours are made once, for all copies, when one of them is asked") {
  int made = 0;
  const FallbackColors colors(1, [&] {
    if (++made == 1) throw std::runtime_error("no memory");
    return std::make_shared<const ColorList>(1, glm::u8vec3(9));
  });
  const FallbackColors copy = colors;
  const FallbackColors first = first_of(colors, 1);
  CHECK(colors.size() == 1);
  CHECK(first.size() == 1);
  CHECK(copy == colors);
  CHECK(made == 0);
  CHECK_THROWS_WITH(copy.get(), "no memory");
  CHECK_FALSE(colors.are_made());
  CHECK(copy.get() == ColorList{glm::u8vec3(9)});
  CHECK(&colors.get() == &copy.get());
  CHECK(first.get() == copy.get());
  CHECK(made == 2);
}

TEST_CASE("what colours are made of is kept until they are made") {
  auto kept = std::make_shared<int>(1);
  const std::weak_ptr<int> watched = kept;
  const FallbackColors colors(1, [kept = std::move(kept)] { return std::make_shared<const ColorList>(1); });
  CHECK_FALSE(watched.expired());
  (void)colors.get();
  CHECK(watched.expired());
}

TEST_CASE("a snapshot makes no colours, and they are those of its moment in any order of asking") {
  ColoredStore store;
  std::vector<Snapshot> snapshots;
  for (int step = 0; step < 60; ++step) snapshots.push_back(store.next());
  for (const Snapshot& snapshot : snapshots) REQUIRE_FALSE(snapshot.vertex_colors.are_made());
  std::mt19937 random(7);
  std::shuffle(snapshots.begin(), snapshots.end(), random);
  for (const Snapshot& snapshot : snapshots) REQUIRE(snapshot.vertex_colors.get() == defined_colors(snapshot));
}

TEST_CASE("several threads may ask for colours of several snapshots, while the store changes") {
  ColoredStore store;
  std::vector<Snapshot> snapshots;
  for (int step = 0; step < 30; ++step) snapshots.push_back(store.next());
  std::atomic<int> wrong{0};
  const auto ask = [&](std::size_t first) {
    for (std::size_t i = 0; i < snapshots.size(); ++i) {
      const Snapshot& snapshot = snapshots[(first + 7 * i) % snapshots.size()];
      wrong += snapshot.vertex_colors.get() == defined_colors(snapshot) ? 0 : 1;
    }
  };
  std::vector<std::thread> threads;
  for (std::size_t thread = 0; thread < 3; ++thread) threads.emplace_back(ask, 5 * thread);
  for (int step = 0; step < 10; ++step) (void)store.next();
  for (std::thread& thread : threads) thread.join();
  CHECK(wrong == 0);
}

TEST_CASE("snapshots between which nothing has changed have one list of colours") {
  ColoredStore store;
  Snapshot snapshot;
  for (int step = 0; step < 9; ++step) snapshot = store.next();
  VertexColors colors;
  const auto list = colors.of(snapshot.surface, snapshot.views, snapshot.gains);
  CHECK(colors.of(snapshot.surface, snapshot.views, snapshot.gains) == list);
  CHECK(*list == snapshot.vertex_colors.get());
}

}  // namespace
}  // namespace lumatlas
