// SPDX-License-Identifier: GPL-3.0-or-later
// The laws of the store: what any way to build one must keep.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <glm/vec3.hpp>
#include <new>
#include <thread>
#include <utility>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/colors/vertex_colors.h"
#include "atlas/model/model_file.h"
#include "tests/support/scenes/wall_scenes.h"
#include "tests/support/temporary_folder.h"

namespace {

// How many more allocations of this thread succeed; negative: all.
thread_local long allocations_left = -1;

// Called before this thread gets much memory.
constexpr std::size_t kMuchMemory = 100'000;  // bytes
thread_local const std::function<void()>* on_large_allocation = nullptr;

}  // namespace

// Not inlined: what allocates must not be seen beside what frees, which compilers would take for a mismatch.
[[gnu::noinline]] void* operator new(std::size_t bytes) {
  if (bytes >= kMuchMemory && on_large_allocation != nullptr) (*on_large_allocation)();
  if (allocations_left == 0) {
    allocations_left = -1;  // what handles the failure may allocate
    throw std::bad_alloc();
  }
  if (allocations_left > 0) --allocations_left;
  void* const memory = std::malloc(bytes == 0 ? 1 : bytes);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace lumatlas {
namespace {

using Slots = std::vector<ViewSlot>;
using CellIds = std::vector<CellId>;

constexpr std::uint32_t kCells = 5;
constexpr TileOptions kTiles{8, 2, 0};

StoredView small_view(const Surface& surface, const std::string& name, std::uint32_t seed = 0) {
  return traced_view(surface, name, forward_camera(24, 16), position_photograph(24, 16, seed));
}

// Returns what every tile of a small view shows: cell 0, and the last one also `cell`.
std::vector<ShownCell> shown_with(CellId cell) {
  std::vector<ShownCell> shown;
  for (std::uint32_t tile = 0; tile < 6; ++tile) shown.push_back({tile, 0, 1});
  if (cell > 0) shown.push_back({5, cell, 1});
  return shown;
}

// Every cell refers to slots 0 and 1 of three.
std::unique_ptr<Atlas> small_store() {
  const auto surface = wall_and_panel(kCells);
  auto atlas = std::make_unique<Atlas>(surface, 4, kTiles);
  for (ViewSlot slot{0}; slot < 3; ++slot) {
    atlas->insert(small_view(*surface, std::string(1, static_cast<char>('a' + slot)), slot),
                  shown_with(CellId(std::uint32_t{slot})));
  }
  for (CellId cell{0}; cell < kCells; ++cell) atlas->set_references(cell, {0, 1});
  return atlas;
}

bool same(const Snapshot& a, const Snapshot& b) {
  return a.surface == b.surface && a.views == b.views && a.gains == b.gains &&
         a.references.offsets == b.references.offsets && a.references.views == b.references.views &&
         a.cell_seen == b.cell_seen && a.vertex_colors == b.vertex_colors && a.tiles.places == b.tiles.places &&
         a.tiles.first_tile == b.tiles.first_tile;
}

TEST_CASE("no writer starves: a surface is replaced while another thread changes views all the time") {
  const auto surface = wall_and_panel(kCells);
  Atlas atlas(surface, 2, kTiles);
  // Cells that take long to be renumbered, so that a view has always changed meanwhile.
  std::vector<ShownCell> shown;
  for (std::uint32_t tile = 0; tile < 6; ++tile) {
    for (CellId cell{0}; cell < kCells; ++cell) shown.push_back({tile, cell, 1});
  }
  atlas.insert(small_view(*surface, "a"), shown);
  atlas.insert(small_view(*surface, "b"), shown);
  constexpr std::uint32_t kManyCells = 50'000;
  const auto many = std::make_shared<Surface>(*surface);
  many->cells.cells.resize(kManyCells, many->cells.cells[0]);
  CellIds previous_cell(kManyCells);
  for (CellId cell{0}; cell < kManyCells; ++cell) previous_cell[cell] = CellId{cell % kCells};
  const StoredView view = small_view(*surface, "b");

  // Whenever replace_surface() asks for much memory, another thread changes a view, if the store lets it.
  constexpr int kMostWrites = 1000;
  std::atomic<bool> wanted{false}, done{false};
  std::atomic<int> writes{0};
  std::thread writer([&] {
    while (!done) {
      if (wanted) {
        atlas.replace(1, view, shown);
        ++writes;
        wanted = false;
      }
      std::this_thread::yield();
    }
  });
  const std::function<void()> let_write = [&] {
    if (writes >= kMostWrites) return;
    wanted = true;
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(50);
    while (wanted && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  };
  on_large_allocation = &let_write;
  atlas.replace_surface(many, previous_cell);
  on_large_allocation = nullptr;
  done = true;
  writer.join();
  CHECK(writes > 0);
  CHECK(writes < kMostWrites);  // else it ended only because the other thread rested
  CHECK(atlas.surface() == many);
  CHECK(atlas.shown(0)->size() == 6 * kManyCells);
}

TEST_CASE("where memory ends in the middle of a call, the store is as it was") {
  const auto next = wall_and_panel(6);
  const CellIds previous{4, CellId::none, 1, 3, 1, 0};
  struct Call {
    const char* name;
    std::function<std::function<void()>(Atlas&)> prepare;  // what is allocated before the call is not the store's
  };
  const std::vector<Call> calls{
      {"replace_surface",
       [&](Atlas& atlas) -> std::function<void()> { return [&] { atlas.replace_surface(next, previous); }; }},
      {"replace_surface, with poses",
       [&](Atlas& atlas) -> std::function<void()> {
         const std::vector<ViewPose> poses{{2, forward_camera(24, 16, {0.1, 0, 0})}, {0, forward_camera(24, 16)}};
         return [&, poses] { atlas.replace_surface(next, previous, poses); };
       }},
      {"set_references",
       [](Atlas& atlas) -> std::function<void()> { return [&atlas] {
                                                     atlas.set_references(2, {1, 2});
                                                   }; }},
      {"mark_seen",
       [](Atlas& atlas) -> std::function<void()> {
         return [&atlas] {
           const std::vector<CellPixels> seen{{1, 1}, {3, 1}};
           atlas.mark_seen(seen);
         };
       }},
      {"insert",
       [](Atlas& atlas) -> std::function<void()> {
         return [&atlas, view = small_view(*atlas.surface(), "d")] { atlas.insert(view, shown_with(3)); };
       }},
      {"replace",
       [](Atlas& atlas) -> std::function<void()> {
         return [&atlas, view = small_view(*atlas.surface(), "e", 9)] { atlas.replace(1, view, shown_with(3)); };
       }},
      {"set_poses",
       [](Atlas& atlas) -> std::function<void()> {
         const std::vector<ViewPose> poses{{2, forward_camera(24, 16, {0.1, 0, 0})}, {0, forward_camera(24, 16)}};
         return [&atlas, poses] { atlas.set_poses(poses); };
       }},
      {"replace_mask",
       [](Atlas& atlas) -> std::function<void()> {
         return
             [&atlas, mask = small_view(*atlas.surface(), "e", 9).mask] { atlas.replace_mask(1, mask, shown_with(3)); };
       }},
      {"retile",
       [](Atlas& atlas) -> std::function<void()> {
         std::vector<SharedShownCells> none(4, std::make_shared<const std::vector<ShownCell>>());
         return [&atlas, none] { atlas.retile({16, 2, 0}, none); };
       }},
      {"set_tile_limit", [](Atlas& atlas) -> std::function<void()> { return [&atlas] { atlas.set_tile_limit(100); }; }},
  };
  for (const Call& call : calls) {
    CAPTURE(call.name);
    const auto atlas = small_store();
    const Snapshot before = atlas->snapshot();
    const std::function<void()> run = call.prepare(*atlas);
    bool ended = false;
    long allocations = 0;
    for (; !ended; ++allocations) {
      CAPTURE(allocations);
      REQUIRE(allocations < 10'000);
      try {
        allocations_left = allocations;
        run();
        ended = true;
      } catch (const std::bad_alloc&) {
      }
      allocations_left = -1;
      if (!ended) REQUIRE(same(atlas->snapshot(), before));
    }
    // And what succeeds at last is what succeeds at once.
    const auto at_once = small_store();
    (void)at_once->snapshot();
    call.prepare (*at_once)();
    const Snapshot after = atlas->snapshot(), expected = at_once->snapshot();
    CHECK(after.references.offsets == expected.references.offsets);
    CHECK(after.references.views == expected.references.views);
    CHECK(after.cell_seen == expected.cell_seen);
    CHECK(after.vertex_colors == expected.vertex_colors);
    CHECK(after.tiles.first_tile == expected.tiles.first_tile);
  }
}

TEST_CASE("a tile policy that asks its store for a snapshot is refused, and the store goes on") {
  const auto surface = wall_and_panel(kCells);
  Atlas* store = nullptr;
  enum class Asks { nothing, snapshot, set_tile_limit, retile } asks = Asks::nothing;
  const TilePolicy policy = [&](const TileDemand& demand) {
    CHECK(store->size() == 1);  // any other call is free to it
    if (asks == Asks::snapshot) (void)store->snapshot();
    if (asks == Asks::set_tile_limit) store->set_tile_limit(3);
    if (asks == Asks::retile) (void)store->retile(kTiles, {});
    return TileChoice{{{0, 0}}, demand.references};
  };
  Atlas atlas(surface, 1, {8, 2, 2}, policy);
  store = &atlas;
  atlas.insert(small_view(*surface, "a"), shown_with(0));
  atlas.set_references(0, {0});
  for (const Asks what : {Asks::snapshot, Asks::set_tile_limit, Asks::retile}) {
    asks = what;
    CHECK_THROWS_MATCHES(atlas.snapshot(), std::logic_error,
                         Catch::Message("atlas: its tile policy asks for a snapshot, or for other tiles, while it "
                                        "chooses those of a snapshot"));
  }
  asks = Asks::nothing;
  CHECK(atlas.snapshot().tiles.resident_tiles() == 1);
}

TEST_CASE("a caller's surface stays valid while another thread replaces the atlas's surface") {
  Atlas atlas(wall_and_panel(kCells), 1);
  const CellIds same_cells{0, 1, 2, 3, 4};
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (int step = 0; step < 2000; ++step) atlas.replace_surface(wall_and_panel(kCells), same_cells);
    done = true;
  });
  std::size_t faces = 0, looks = 0;
  while (!done || looks == 0) {
    const std::shared_ptr<const Surface> surface = atlas.surface();
    faces += surface->mesh.faces.size();
    ++looks;
  }
  writer.join();
  CHECK(faces == looks * atlas.surface()->mesh.faces.size());
}

TEST_CASE("a tile policy is shown no tiles of a view that is gone") {
  const auto surface = wall_and_panel(kCells);
  std::vector<ViewTile> resident;
  std::vector<ViewSlot> gone;  // slots without a view of which it was shown tiles
  const TilePolicy policy = [&](const TileDemand& demand) {
    resident.assign(demand.resident.begin(), demand.resident.end());
    for (const ViewTile& tile : resident) {
      if (!demand.views[tile.view]) gone.push_back(tile.view);
    }
    TileChoice choice{{}, demand.references};
    for (ViewSlot slot{0}; slot < demand.views.size(); ++slot) {
      if (demand.views[slot]) choice.tiles.push_back({ViewSlot{slot}, 0});
    }
    return choice;
  };
  Atlas atlas(surface, 3, {8, 2, 4}, policy);
  for (const char* name : {"a", "b", "c"}) atlas.insert(small_view(*surface, name), shown_with(0));
  atlas.set_references(0, {0, 1, 2});
  (void)atlas.snapshot();
  atlas.set_references(0, {1, 2});
  atlas.erase(0);
  (void)atlas.snapshot();
  CHECK(gone.empty());
  REQUIRE(resident.size() == 2);
  CHECK((resident[0].view == 1 && resident[1].view == 2));
}

TEST_CASE("a snapshot costs what has changed: a moved view looks at no other view's samples") {
  constexpr std::size_t kViews = 40;
  const auto surface = wall_and_panel(kCells);
  const std::size_t vertices = surface->mesh.positions.size();
  std::vector<std::shared_ptr<const StoredView>> views;
  std::vector<glm::dvec3> gains(kViews, glm::dvec3(1));
  for (ViewSlot slot{0}; slot < kViews; ++slot) {
    views.push_back(std::make_shared<const StoredView>(small_view(*surface, "a", slot)));
  }
  VertexColors colors;
  (void)colors.of(surface, views, gains);
  std::uint64_t counted = colors.samples_counted();
  CHECK(counted <= kViews * vertices);
  const auto steps = [&] {
    (void)colors.of(surface, views, gains);
    return colors.samples_counted() - std::exchange(counted, colors.samples_counted());
  };
  views[7] = std::make_shared<const StoredView>(
      traced_view(*surface, "a", forward_camera(24, 16, {0.2, 0, 0}), position_photograph(24, 16, 7)));
  CHECK(steps() <= 2 * vertices);  // taken away, and added
  gains[3] = {2, 1, 1};
  CHECK(steps() <= 2 * vertices);
  views[11].reset();
  CHECK(steps() <= vertices);
  CHECK(steps() == 0);

  // The sums are those of the views that are there, to the bit, in any order.
  VertexColorMean forward(surface->mesh), backward(surface->mesh);
  for (std::size_t slot = 0; slot < kViews; ++slot) {
    if (views[slot]) forward.add(*views[slot], gains[slot]);
    if (views[kViews - 1 - slot]) backward.add(*views[kViews - 1 - slot], gains[kViews - 1 - slot]);
  }
  CHECK(*colors.of(surface, views, gains) == forward.colors());
  CHECK(forward.colors() == backward.colors());
}

std::vector<std::shared_ptr<const StoredView>> five_views(const Surface& surface) {
  std::vector<std::shared_ptr<const StoredView>> views;
  for (ViewSlot slot{0}; slot < 5; ++slot) {
    views.push_back(std::make_shared<const StoredView>(small_view(surface, "a", slot)));
  }
  return views;
}

TEST_CASE("a snapshot costs what has changed: where a vertex moved, samples of that vertex") {
  const auto surface = wall_and_panel(kCells);
  std::vector<std::shared_ptr<const StoredView>> views = five_views(*surface);
  const std::size_t kViews = views.size();
  const std::vector<glm::dvec3> gains(kViews, glm::dvec3(1));
  VertexColors colors;
  (void)colors.of(surface, views, gains);
  auto before = surface;
  for (std::size_t vertex = 0; vertex < surface->mesh.positions.size(); ++vertex) {
    const std::uint64_t counted = colors.samples_counted();
    const auto moved = std::make_shared<Surface>(*before);
    moved->mesh.positions[vertex].x += 0.3F;
    const auto followed = colors.of(moved, views, gains);
    CHECK(colors.samples_counted() - counted <= 2 * kViews);  // taken away, and added
    VertexColors anew;
    CHECK(*followed == *anew.of(moved, views, gains));
    before = moved;
  }
  // A view that changes at the same time is followed too; another number of vertices begins anew.
  const auto moved = std::make_shared<Surface>(*before);
  for (glm::vec3& position : moved->mesh.positions) position.y -= 0.2F;
  views[2] = std::make_shared<const StoredView>(small_view(*moved, "b", 9));
  VertexColors anew;
  CHECK(*colors.of(moved, views, gains) == *anew.of(moved, views, gains));
  const auto other = wall_and_panel(2);
  CHECK(*colors.of(other, views, gains) == *anew.of(other, views, gains));
}

TEST_CASE("a snapshot costs what has changed: of a surface that has grown, samples of the vertices at new places") {
  const auto surface = wall_and_panel(kCells);
  std::vector<std::shared_ptr<const StoredView>> views = five_views(*surface);
  const std::size_t kViews = views.size();
  const std::vector<glm::dvec3> gains(kViews, glm::dvec3(1));
  VertexColors colors;
  (void)colors.of(surface, views, gains);
  const auto next = std::make_shared<Surface>(*surface);
  std::vector<glm::vec3>& positions = next->mesh.positions;
  const auto last = static_cast<std::uint32_t>(positions.size() - 1);
  for (int version = 0; version < 40; ++version) {
    // Vertices have other numbers each time, one is at another place, and one face less is there.
    std::reverse(positions.begin(), positions.end());
    for (glm::uvec3& face : next->mesh.faces) face = glm::uvec3(last) - face;
    positions[static_cast<std::size_t>(version) % positions.size()].y += 0.25F;
    if (next->mesh.faces.size() > 2) next->mesh.faces.pop_back();
    if (version == 20) views[3].reset();
    if (version == 25) views[3] = std::make_shared<const StoredView>(small_view(*surface, "b", 9));
    const std::uint64_t counted = colors.samples_counted();
    const auto now = std::make_shared<const Surface>(*next);
    const auto followed = colors.of(now, views, gains);
    if (version < 5) CHECK(colors.samples_counted() - counted <= kViews);
    VertexColors anew;
    CHECK(*followed == *anew.of(now, views, gains));
  }
}

// Returns the bytes of a view in memory.
std::size_t bytes_of(const StoredView& view) {
  return view.photograph->bytes() + view.mask->bytes();
}

TEST_CASE("memory follows resident tiles") {
  const auto surface = wall_and_panel(kCells);
  constexpr TileOptions kLayout{64, 2, 0};
  Atlas atlas(surface, 1, kLayout);
  const Camera camera = forward_camera(512, 512);
  atlas.insert(traced_view(*surface, "a", camera, position_photograph(512, 512)), {{9, 0, 1}});
  atlas.set_references(0, {0});
  const TemporaryFolder folder;
  write_model(folder.path(), atlas.snapshot(), {});
  const Snapshot read = read_model(folder.path()).snapshot;
  REQUIRE(read.tiles.resident_tiles() == 1);
  const std::size_t texels = kLayout.place_px() * kLayout.place_px();
  CHECK(bytes_of(*read.views[0]) <= 16 * texels);  // twice what a texel takes; a tile is a 64th of the view
}

}  // namespace
}  // namespace lumatlas
