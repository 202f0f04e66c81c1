// SPDX-License-Identifier: GPL-3.0-or-later
// A renderer that takes the next snapshot piece by piece draws the former one meanwhile, and then what load() gives.
#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "blend/gl/photograph_array.h"
#include "blend/renderer.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/view_parts.h"

namespace lumatlas {
namespace {

constexpr TileOptions kTiles{16, 2, 0};
const Camera kCamera = room_camera(2);

// Takes a snapshot in as many pieces as there are, with a picture after each fifth. Returns how many of these were
// drawn before the snapshot was whole; each must be `before`, if that is given.
int take_in_pieces(Renderer& renderer, const Snapshot& snapshot, const std::optional<Rendering>& before) {
  NextSnapshot next = renderer.begin(snapshot, {});
  std::thread worker([&next] { next.prepare(); });
  int pieces = 0;
  int pictures = 0;
  int different = 0;
  while (!renderer.upload(0)) {
    if (!before || ++pieces % 5 > 0) continue;
    different += renderer.render(kCamera, {}).picture.rgb != before->picture.rgb;
    ++pictures;
  }
  worker.join();
  CHECK(renderer.upload(0));  // each frame calls it, also when all is there
  CHECK(different == 0);
  CHECK(next.waiting_bytes() == 0);
  return pictures;
}

// Changes of a store, one after another: of photographs, masks, depths, poses, references, colours and the surface.
std::vector<std::pair<const char*, std::function<void(Atlas&)>>> changes() {
  const auto change_view = [](Atlas& atlas, ViewSlot slot, const auto& change) {
    StoredView view = *atlas.view(slot);
    change(view);
    atlas.replace(slot, std::move(view), *atlas.shown(slot));
  };
  return {{"a photograph",
           [=](Atlas& atlas) {
             change_view(atlas, 4,
                         [](StoredView& view) { change_colors(view, [](std::uint8_t value) { return 255 - value; }); });
           }},
          {"a mask",
           [=](Atlas& atlas) {
             change_view(atlas, 1, [](StoredView& view) {
               std::vector<std::uint8_t>& validity = own_mask(view).validity.values();
               std::fill_n(validity.begin(), validity.size() / 2, std::uint8_t{0});
             });
           }},
          {"a mask that is soft",
           [=](Atlas& atlas) {
             change_view(atlas, 1, [](StoredView& view) {
               std::vector<std::uint8_t>& validity = own_mask(view).validity.values();
               std::replace(validity.begin(), validity.end(), std::uint8_t{255}, std::uint8_t{128});
             });
           }},
          {"depths",
           [=](Atlas& atlas) {
             change_view(atlas, 2, [](StoredView& view) {
               for (float& depth : own_mask(view).depth.values()) depth *= 1.5F;
             });
           }},
          {"a pose",
           [=](Atlas& atlas) {
             change_view(atlas, 3, [](StoredView& view) { view.camera.cam_from_world_translation.x += 0.05; });
           }},
          {"the same bytes again",
           [=](Atlas& atlas) {
             change_view(atlas, 3, [](StoredView& view) { change_photograph(view, [](Photograph&) {}); });
           }},
          {"references",
           [](Atlas& atlas) {
             for (CellId cell{0}; cell < 6; ++cell) {
               std::vector<ViewSlot> slots = atlas.references(cell);
               if (!slots.empty()) slots.pop_back();
               atlas.set_references(cell, slots);
             }
           }},
          {"all photographs",
           [=](Atlas& atlas) {
             for (ViewSlot slot{0}; slot < 6; ++slot) {
               change_view(atlas, slot,
                           [](StoredView& view) { change_colors(view, [](std::uint8_t value) { return value / 2; }); });
             }
           }},
          {"the surface", [](Atlas& atlas) {
             const auto next = std::make_shared<const Surface>(*atlas.surface());
             std::vector<CellId> same_cells;
             for (CellId cell{0}; cell < next->cells.cells.size(); ++cell) same_cells.emplace_back(cell);
             atlas.replace_surface(next, same_cells);
           }}};
}

TEST_CASE("a next snapshot is drawn once it is whole, as load() draws it to the byte, and the former one until then") {
  const TileOptions layout =
      GENERATE(as<TileOptions>(), kTiles, TileOptions{64, 8, 0}, kWholeViews, TileOptions{16, 4, 0, TexelFormat::bc7});
  const bool embedded = GENERATE(false, true);
  const bool aside = GENERATE(false, true);
  const std::optional<EglContext> context = context_or_skip({.debug = true, .embedded = embedded});
  if (!context || !driver_takes(layout.texels)) return;
  if (layout.texels == TexelFormat::bc7 && aside != embedded) return;  // compressing takes long
  const auto atlas = room_atlas(6, {}, layout);
  Renderer gradual({.blocks = true, .allocate_aside = aside}), at_once({.blocks = true});
  at_once.load(atlas->snapshot());
  CHECK(take_in_pieces(gradual, atlas->snapshot(), std::nullopt) == 0);
  Rendering former = at_once.render(kCamera, {});
  REQUIRE(gradual.render(kCamera, {}).picture.rgb == former.picture.rgb);
  int pictures = 0;
  for (const auto& [what, change] : changes()) {
    CAPTURE(layout.tile_px, embedded, aside, what);
    change(*atlas);
    at_once.load(atlas->snapshot());
    pictures += take_in_pieces(gradual, atlas->snapshot(), former);
    former = at_once.render(kCamera, {});
    const Rendering taken = gradual.render(kCamera, {});
    CHECK(taken.picture.rgb == former.picture.rgb);
    CHECK(taken.state == former.state);
    // What has been taken so can be drawn from another camera and with cells of another width, and loaded over.
    BlendOptions narrow;
    narrow.border_width = 0;
    CHECK(gradual.render(room_camera(3), narrow).picture.rgb == at_once.render(room_camera(3), narrow).picture.rgb);
    CHECK(gradual.render(kCamera, {}).picture.rgb == former.picture.rgb);
  }
  CHECK(pictures > 10);
  Renderer loaded_over({.join_cells = false, .blocks = true});
  loaded_over.load(room_snapshot(3, {}, layout));
  gradual.load(room_snapshot(3, {}, layout));
  CHECK(gradual.render(kCamera, {}).picture.rgb == loaded_over.render(kCamera, {}).picture.rgb);
}

TEST_CASE("of a next snapshot only tiles that show something else are copied") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const auto atlas = room_atlas(6, {}, kTiles);
  Renderer renderer;
  take_in_pieces(renderer, atlas->snapshot(), std::nullopt);
  const RendererWork all = renderer.work();
  const auto show = [&] {
    const RendererWork before = renderer.work();
    take_in_pieces(renderer, atlas->snapshot(), renderer.render(kCamera, {}));
    const RendererWork now = renderer.work();
    return RendererWork{now.meshes - before.meshes, now.color_bytes - before.color_bytes, 0,
                        now.depth_bytes - before.depth_bytes};
  };
  const RendererWork nothing = show();
  CHECK(nothing.color_bytes == 0);
  CHECK(nothing.depth_bytes == 0);
  CHECK(nothing.meshes == 0);
  for (const auto& [what, change] : changes()) {
    CAPTURE(what);
    change(*atlas);
    const RendererWork work = show();
    const std::string name = what;
    if (name == "all photographs") {
      CHECK(work.color_bytes == all.color_bytes);
    } else if (name == "a photograph" || name == "a mask" || name == "a mask that is soft" || name == "depths") {
      CHECK(work.color_bytes > 0);
      CHECK(work.color_bytes < all.color_bytes / 2);
    } else {
      CHECK(work.color_bytes == 0);
      CHECK(work.depth_bytes == 0);
    }
    CHECK(work.meshes <= 1);  // the first change takes joined cells apart
  }
}

TEST_CASE("a picture with cells of another width, or a step that is switched, may come between") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const auto atlas = room_atlas(6, {}, kTiles);
  Renderer gradual, at_once;
  gradual.load(atlas->snapshot());
  at_once.load(atlas->snapshot());
  (void)gradual.render(kCamera, {});
  const bool switches = GENERATE(false, true);
  for (const auto& [what, change] : changes()) {
    CAPTURE(what, switches);
    change(*atlas);
    NextSnapshot next = gradual.begin(atlas->snapshot(), {});
    next.prepare();
    BlendOptions narrow;
    narrow.border_width = 0;
    if (switches) gradual.set_options({.join_cells = false});
    (void)gradual.render(kCamera, narrow);
    while (!gradual.upload(0)) {
    }
    if (switches) gradual.set_options({});
    at_once.load(atlas->snapshot());
    CHECK(gradual.render(kCamera, {}).picture.rgb == at_once.render(kCamera, {}).picture.rgb);
  }
}

TEST_CASE("no more texels wait than the option allows, and the one who waits is released") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot snapshot = room_snapshot(6, {}, kTiles);
  const std::uint64_t tile_bytes = array_shape(snapshot).bytes() / array_shape(snapshot).places();
  enum class End { uploaded, cancelled, loaded, begun, destroyed };
  const End end = GENERATE(End::uploaded, End::cancelled, End::loaded, End::begun, End::destroyed);
  std::optional<Renderer> renderer;
  renderer.emplace(RendererOptions{.waiting_bytes = 1, .allocate_aside = GENERATE(false, true)});
  NextSnapshot next = renderer->begin(snapshot, {});
  std::thread worker([next]() mutable { next.prepare(); });
  while (next.waiting_bytes() == 0) std::this_thread::yield();
  CHECK(next.waiting_bytes() <= 2 * tile_bytes);  // one tile; a share of a level's bytes is rounded
  switch (end) {
    case End::uploaded:
      while (!renderer->upload(0)) CHECK(next.waiting_bytes() <= 2 * tile_bytes);
      break;
    case End::cancelled:
      next.cancel();
      CHECK(renderer->upload(0));
      CHECK_THROWS_AS(renderer->render(kCamera, {}), std::invalid_argument);  // there is no former one
      break;
    case End::loaded:
      renderer->load(snapshot);
      break;
    case End::begun: {
      NextSnapshot other = renderer->begin(snapshot, {});
      worker.join();
      worker = std::thread([other]() mutable { other.prepare(); });
      while (!renderer->upload(1)) {
      }
      break;
    }
    case End::destroyed:
      renderer.reset();
      break;
  }
  worker.join();
  if (end == End::cancelled || end == End::destroyed) return;
  Renderer fresh;
  fresh.load(snapshot);
  CHECK(renderer->render(kCamera, {}).picture.rgb == fresh.render(kCamera, {}).picture.rgb);
}

TEST_CASE("a next snapshot that is given up halfway leaves nothing of it in what is loaded afterwards") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const auto atlas = room_atlas(6, {}, kTiles);
  const Snapshot whole = atlas->snapshot();
  StoredView changed = *atlas->view(ViewSlot{5});
  const std::vector<ShownCell> shown = *atlas->shown(ViewSlot{5});
  change_colors(changed, [](std::uint8_t value) { return 255 - value; });
  Renderer renderer({.join_cells = false}), fresh({.join_cells = false});
  renderer.load(whole);
  const std::size_t cells = atlas->surface()->cells.cells.size();
  std::vector<std::vector<ViewSlot>> references;
  for (CellId cell{0}; cell < cells; ++cell) {
    references.push_back(atlas->references(cell));
    std::vector<ViewSlot> others = references.back();
    std::erase(others, ViewSlot{5});
    atlas->set_references(cell, others);
  }
  atlas->erase(ViewSlot{5});
  renderer.load(atlas->snapshot());
  // The places of the view that left are free, and what comes next is written there.
  atlas->insert_at(ViewSlot{5}, changed, shown);
  for (CellId cell{0}; cell < cells; ++cell) atlas->set_references(cell, references[cell]);
  NextSnapshot next = renderer.begin(atlas->snapshot(), {});
  next.prepare();
  bool is_whole = false;
  while (!is_whole && next.waiting_bytes() > 1000) is_whole = renderer.upload(0);
  REQUIRE_FALSE(is_whole);
  next.cancel();
  REQUIRE(renderer.upload(0));
  renderer.load(whole);
  fresh.load(whole);
  for (const std::size_t place : {0, 2, 5}) {
    CHECK(renderer.render(room_camera(place), {}).picture.rgb == fresh.render(room_camera(place), {}).picture.rgb);
  }
}

TEST_CASE("a next snapshot whose texels may not wait is refused on the thread that uploads") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer({.waiting_bytes = 1});
  NextSnapshot next = renderer.begin(room_snapshot(6, {}, kTiles), {});
  CHECK_THROWS_AS(next.prepare(), std::logic_error);
  CHECK_THROWS_AS(renderer.upload(0), std::logic_error);
}

TEST_CASE("texels wait one piece at a time where the option allows none") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer({.waiting_bytes = 0}), fresh;
  const Snapshot snapshot = room_snapshot(6, {}, kTiles);
  take_in_pieces(renderer, snapshot, std::nullopt);
  fresh.load(snapshot);
  CHECK(renderer.render(kCamera, {}).picture.rgb == fresh.render(kCamera, {}).picture.rgb);
}

TEST_CASE("a bad next snapshot is refused where it is prepared and where it is uploaded, and the former one stays") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot good = room_snapshot(4, {}, kTiles);
  Renderer renderer;
  renderer.load(good);
  const Rendering before = renderer.render(kCamera, {});
  Snapshot bad = good;
  bad.gains.front().x = -1;
  NextSnapshot next = renderer.begin(bad, {});
  CHECK(!renderer.upload(0));  // nothing is prepared yet
  CHECK_THROWS_AS(next.prepare(), std::invalid_argument);
  CHECK_THROWS_AS(renderer.upload(0), std::invalid_argument);
  CHECK(renderer.upload(0));
  CHECK(renderer.render(kCamera, {}).picture.rgb == before.picture.rgb);
  CHECK_THROWS_AS(next.prepare(), std::invalid_argument);
  BlendOptions impossible;
  impossible.views = 0;
  CHECK_THROWS_AS(renderer.begin(good, impossible), std::invalid_argument);
  NextSnapshot again = renderer.begin(good, {});
  again.prepare();
  CHECK_THROWS_AS(renderer.upload(-1), std::invalid_argument);
  CHECK(renderer.upload(1e4));
}

}  // namespace
}  // namespace lumatlas
