// SPDX-License-Identifier: GPL-3.0-or-later
// The steps that a next snapshot takes on the thread that draws: each is small, all together are what there is to copy,
// and a snapshot may be given up after any of them.
#include <epoxy/gl.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdint>
#include <future>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "blend/gl/gradual_copies.h"
#include "blend/gl/photograph_array.h"
#include "blend/gl/side_thread.h"
#include "blend/gl/snapshot_upload.h"
#include "blend/renderer.h"
#include "blend/tables/snapshot_preparation.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/view_parts.h"

namespace lumatlas {
namespace {

constexpr TileOptions kTilesOfSteps{16, 2, 0};
const Camera kCameraOfSteps = room_camera(2);

// Each face in four, with the same cells.
std::shared_ptr<const Surface> in_four(const Surface& surface) {
  auto finer = std::make_shared<Surface>();
  finer->mesh.positions = surface.mesh.positions;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    std::vector<glm::vec3>& positions = finer->mesh.positions;
    const auto [known, is_new] = middles.emplace(std::minmax(a, b), static_cast<std::uint32_t>(positions.size()));
    if (is_new) positions.push_back((positions[a] + positions[b]) / 2.0F);
    return known->second;
  };
  std::vector<CellId> cells;
  for (std::size_t face = 0; face < surface.mesh.faces.size(); ++face) {
    const glm::uvec3 corners = surface.mesh.faces[face];
    const glm::uvec3 half(middle(corners.x, corners.y), middle(corners.y, corners.z), middle(corners.z, corners.x));
    finer->mesh.faces.insert(
        finer->mesh.faces.end(),
        {{corners.x, half.x, half.z}, {half.x, corners.y, half.y}, {half.z, half.y, corners.z}, half});
    cells.insert(cells.end(), 4, surface.cells.cell_of_face[face]);
  }
  finer->cells = measure_cells(finer->mesh, std::move(cells), surface.cells.size);
  return finer;
}

void refine_surface(Atlas& atlas, int times) {
  std::shared_ptr<const Surface> surface = atlas.surface();
  for (int i = 0; i < times; ++i) surface = in_four(*surface);
  std::vector<CellId> same_cells;
  for (CellId cell{0}; cell < surface->cells.cells.size(); ++cell) same_cells.emplace_back(cell);
  atlas.replace_surface(surface, same_cells);
}

void invert_photographs(Atlas& atlas) {
  for (ViewSlot slot{0}; slot < atlas.size(); ++slot) {
    StoredView view = *atlas.view(slot);
    change_colors(view, [](std::uint8_t value) { return 255 - value; });
    atlas.replace(slot, std::move(view), *atlas.shown(slot));
  }
}

// Uploads in steps of no time. Returns the steps; each call of upload() must do one, until the last.
std::vector<UploadStep> steps_of(Renderer& renderer, const Snapshot& snapshot) {
  std::vector<UploadStep> steps;
  renderer.set_upload_listener([&](const UploadStep& step) { steps.push_back(step); });
  NextSnapshot next = renderer.begin(snapshot, {});
  next.prepare();
  std::size_t calls = 0;
  bool is_whole = false;
  while (!is_whole) {
    is_whole = renderer.upload(0);
    CHECK(steps.size() == ++calls);
  }
  renderer.set_upload_listener({});
  return steps;
}

std::uint64_t bytes_of_steps(const std::vector<UploadStep>& steps, const std::string& what) {
  std::uint64_t bytes = 0;
  for (const UploadStep& step : steps) bytes += step.what == what ? step.bytes : 0;
  return bytes;
}

std::size_t count_of_steps(const std::vector<UploadStep>& steps, const std::string& what) {
  return static_cast<std::size_t>(
      std::count_if(steps.begin(), steps.end(), [&](const UploadStep& step) { return step.what == what; }));
}

TEST_CASE("no step has more than a piece, and all steps together are what there is to copy") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const bool aside = GENERATE(false, true);
  const TileOptions layout = GENERATE(as<TileOptions>(), kTilesOfSteps, kWholeViews);
  CAPTURE(aside, layout.tile_px);
  const auto atlas = room_atlas(6, {}, layout);
  Renderer renderer({.waiting_bytes = ~std::uint64_t{0}, .allocate_aside = aside}), fresh;
  renderer.load(atlas->snapshot());
  (void)renderer.render(kCameraOfSteps, {});
  const RendererWork before = renderer.work();
  refine_surface(*atlas, 3);
  invert_photographs(*atlas);
  const Snapshot snapshot = atlas->snapshot();
  const std::vector<UploadStep> steps = steps_of(renderer, snapshot);
  const RendererWork after = renderer.work();
  std::uint64_t allocated_here = 0;
  for (const UploadStep& step : steps) {
    CAPTURE(step.what);
    const std::string what = step.what;
    if (what == "allocation") {
      allocated_here += step.bytes;
    } else {
      CHECK(step.bytes <= kPieceBytes);
      const bool copies = what == "buffer" || what == "table" || what == "tile" || what == "page";
      CHECK((step.bytes > 0) == copies);
    }
  }
  CHECK((allocated_here == 0) == aside);
  CHECK(count_of_steps(steps, "list") == 2);
  CHECK(count_of_steps(steps, "exchange") == 1);
  CHECK(std::string(steps.back().what) == "exchange");
  CHECK(bytes_of_steps(steps, "tile") ==
        after.color_bytes - before.color_bytes + after.depth_bytes - before.depth_bytes);
  // The faces alone, three numbers each, and the least that a vertex of each takes.
  const std::size_t faces = snapshot.surface->mesh.faces.size(), vertices = snapshot.surface->mesh.positions.size();
  REQUIRE(12 * faces > 2 * kPieceBytes);
  CHECK(bytes_of_steps(steps, "buffer") >= 12 * faces + (12 + 3 + 8 + 4) * vertices);
  fresh.load(snapshot);
  CHECK(renderer.render(kCameraOfSteps, {}).picture.rgb == fresh.render(kCameraOfSteps, {}).picture.rgb);
}

TEST_CASE("an array that grows is copied row by row, and what was on its pages is drawn as before") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const bool aside = GENERATE(false, true);
  const TileOptions layout =
      GENERATE(as<TileOptions>(), kTilesOfSteps, kWholeViews, TileOptions{16, 4, 0, TexelFormat::bc7});
  if (!driver_takes(layout.texels)) return;
  CAPTURE(aside, layout.tile_px, layout.gutter_px);
  const auto atlas = room_atlas(12, {}, layout);
  const Snapshot all = atlas->snapshot();
  Renderer renderer({.blocks = true, .waiting_bytes = ~std::uint64_t{0}, .allocate_aside = aside});
  Renderer fresh({.blocks = true});
  std::size_t pages = 0;
  for (std::size_t views = 1; views <= 12; ++views) {
    CAPTURE(views);
    Atlas part(all.surface, static_cast<std::uint32_t>(views), layout);
    for (ViewSlot slot{0}; slot < views; ++slot) part.insert_at(slot, *atlas->view(slot), *atlas->shown(slot));
    for (CellId cell{0}; cell < all.surface->cells.cells.size(); ++cell) {
      std::vector<ViewSlot> slots = atlas->references(cell);
      std::erase_if(slots, [&](ViewSlot slot) { return slot >= views; });
      part.set_references(cell, slots);
    }
    const Snapshot snapshot = part.snapshot();
    pages += count_of_steps(steps_of(renderer, snapshot), "page");
    fresh.load(snapshot);
    for (const std::size_t place : {0, 2, 5}) {
      CHECK(renderer.render(room_camera(place), {}).picture.rgb == fresh.render(room_camera(place), {}).picture.rgb);
    }
  }
  CHECK(pages > 0);
}

TEST_CASE("given up after any step, a next snapshot leaves the former one as it was, and the next may follow") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const bool aside = GENERATE(false, true);
  enum class End { cancelled, begun, loaded, destroyed };
  const End end = GENERATE(End::cancelled, End::begun, End::loaded, End::destroyed);
  CAPTURE(aside, static_cast<int>(end));
  constexpr TileOptions kFew{64, 2, 0};
  const auto atlas = room_atlas(4, {}, kFew);
  const Snapshot former = atlas->snapshot();
  refine_surface(*atlas, 1);
  invert_photographs(*atlas);
  const Snapshot snapshot = atlas->snapshot();
  const RendererOptions options{.waiting_bytes = ~std::uint64_t{0}, .allocate_aside = aside};
  Renderer fresh;
  fresh.load(former);
  const Rendering before = fresh.render(kCameraOfSteps, {});
  fresh.load(snapshot);
  const Rendering after = fresh.render(kCameraOfSteps, {});
  REQUIRE(before.picture.rgb != after.picture.rgb);
  std::optional<Renderer> renderer;
  bool is_whole = false;
  for (std::size_t given_up_after = 0; !is_whole; ++given_up_after) {
    CAPTURE(given_up_after);
    if (!renderer) {
      renderer.emplace(options);
      renderer->load(former);
      (void)renderer->render(kCameraOfSteps, {});
    }
    NextSnapshot next = renderer->begin(snapshot, {});
    next.prepare();
    for (std::size_t step = 0; step < given_up_after && !is_whole; ++step) is_whole = renderer->upload(0);
    if (is_whole) break;
    switch (end) {
      case End::cancelled:
        next.cancel();
        CHECK(renderer->upload(0));
        break;
      case End::begun:
        next = renderer->begin(former, {});
        break;
      case End::loaded:
        renderer->load(former);
        break;
      case End::destroyed:
        renderer.reset();
        continue;
    }
    CHECK(renderer->render(kCameraOfSteps, {}).picture.rgb == before.picture.rgb);
  }
  CHECK(renderer->render(kCameraOfSteps, {}).picture.rgb == after.picture.rgb);
}

// Returns a renderer that has drawn the store once.
Renderer renderer_of(const Atlas& atlas, bool allocates_aside) {
  Renderer renderer({.waiting_bytes = ~std::uint64_t{0}, .allocate_aside = allocates_aside});
  renderer.load(atlas.snapshot());
  (void)renderer.render(kCameraOfSteps, {});
  return renderer;
}

// Counts the textures of the current context.
std::size_t textures_there() {
  constexpr GLuint kMostNames = 1000;  // drivers begin with the smallest
  std::size_t count = 0;
  for (GLuint name = 1; name < kMostNames; ++name) count += glIsTexture(name) == GL_TRUE ? 1 : 0;
  return count;
}

// Waits until as many textures are there, at most some seconds. Returns how many are.
std::size_t textures_that_stay(std::size_t expected) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (textures_there() != expected && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  return textures_there();
}

TEST_CASE("of an array that was replaced nothing is left after the second picture") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const bool aside = GENERATE(false, true);
  CAPTURE(aside);
  const auto atlas = room_atlas(4, {}, {64, 2, 0});
  Renderer renderer = renderer_of(*atlas, aside);
  const std::size_t before = textures_there();
  REQUIRE(before > 3);
  for (int round = 0; round < 3; ++round) {
    invert_photographs(*atlas);
    (void)steps_of(renderer, atlas->snapshot());
    for (int picture = 0; picture < 2; ++picture) (void)renderer.render(kCameraOfSteps, {});
    CHECK(textures_that_stay(before) == before);
  }
}

TEST_CASE("without a picture one replaced array at most is kept, and load() frees it before it returns") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const bool aside = GENERATE(false, true);
  CAPTURE(aside);
  const auto atlas = room_atlas(4, {}, {64, 2, 0});
  Renderer renderer = renderer_of(*atlas, aside);
  const std::size_t before = textures_there();
  const std::size_t kept = aside ? 2 : 0;  // photographs and depths
  for (int round = 0; round < 4; ++round) {
    CAPTURE(round);
    invert_photographs(*atlas);
    (void)steps_of(renderer, atlas->snapshot());
    CHECK(textures_that_stay(before + kept) == before + kept);
  }
  renderer.load(atlas->snapshot());
  CHECK(textures_there() == before);
}

TEST_CASE("before an array is allocated the replaced one is freed, and afterwards no texture is made until the last") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const auto atlas = room_atlas(4, {}, {64, 2, 0});
  Renderer renderer = renderer_of(*atlas, true);
  std::optional<std::size_t> first_round;
  for (int round = 0; round < 3; ++round) {
    CAPTURE(round);
    invert_photographs(*atlas);
    std::optional<std::size_t> allocated;
    int different = 0;
    renderer.set_upload_listener([&](const UploadStep& step) {
      const std::string what = step.what;
      if (what == "exchange" || what == "allocation" || what == "wait") return;
      if (what == "list" && !allocated) return;
      if (!allocated) allocated = textures_there();
      different += textures_there() != *allocated;
    });
    NextSnapshot next = renderer.begin(atlas->snapshot(), {});
    next.prepare();
    while (!renderer.upload(0)) {
    }
    REQUIRE(allocated.has_value());
    CHECK(different == 0);
    if (!first_round) first_round = allocated;
    CHECK(*allocated == *first_round);
  }
}

TEST_CASE("a next snapshot that is given up while it is uploaded is drawn as a whole or not at all") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const bool aside = GENERATE(false, true);
  CAPTURE(aside);
  const auto atlas = room_atlas(4, {}, {64, 2, 0});
  const Snapshot former = atlas->snapshot();
  invert_photographs(*atlas);
  const Snapshot snapshot = atlas->snapshot();
  Renderer fresh;
  fresh.load(former);
  const Rendering before = fresh.render(kCameraOfSteps, {});
  fresh.load(snapshot);
  const Rendering after = fresh.render(kCameraOfSteps, {});
  REQUIRE(before.picture.rgb != after.picture.rgb);
  int dropped = 0;
  bool is_cancelled = true;
  for (std::size_t last_step = 1; is_cancelled; ++last_step) {
    CAPTURE(last_step);
    Renderer renderer({.waiting_bytes = ~std::uint64_t{0}, .allocate_aside = aside});
    renderer.load(former);
    (void)renderer.render(kCameraOfSteps, {});
    NextSnapshot next = renderer.begin(snapshot, {});
    next.prepare();
    std::size_t steps = 0;
    is_cancelled = false;
    renderer.set_upload_listener([&](const UploadStep& step) {
      if (std::string(step.what) == "wait" || ++steps != last_step) return;
      is_cancelled = std::string(step.what) != "exchange";
      if (is_cancelled) next.cancel();
    });
    bool is_whole = false;
    while (!is_whole && !is_cancelled) is_whole = renderer.upload(1e6);
    dropped += is_whole ? 0 : 1;
    CHECK(renderer.upload(0));
    CHECK(renderer.render(kCameraOfSteps, {}).picture.rgb == (is_whole ? after : before).picture.rgb);
  }
  CHECK(dropped > 4);
}

TEST_CASE("memory of a next snapshot that was given up before it is allocated aside is not allocated") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const bool is_cancelled = GENERATE(false, true);
  FormerSnapshot nothing;
  nothing.array = std::make_shared<ArrayContents>();
  PreparationOptions options;
  options.limits = limits_of_driver();
  options.waiting_bytes = std::numeric_limits<std::uint64_t>::max();
  const auto preparation =
      std::make_shared<SnapshotPreparation>(room_snapshot(4, {}, {64, 2, 0}), std::move(nothing), options);
  preparation->run();
  const std::size_t before = textures_there();
  SideThread side;
  PhotographArray array;
  SnapshotUpload upload(preparation, side, 0);
  CHECK(!upload.allocates_array());
  REQUIRE(upload.step(array) == SnapshotUpload::Progress::goes_on);
  CHECK(upload.allocates_array());
  while (!side.has_context()) std::this_thread::yield();
  REQUIRE(side.makes_objects());
  std::promise<void> gate;
  (void)side.make([opened = gate.get_future().share()] {
    opened.wait();
    return 0;
  });
  REQUIRE(upload.step(array) == SnapshotUpload::Progress::goes_on);
  CHECK(!upload.allocates_array());
  CHECK(upload.step(array) == SnapshotUpload::Progress::waits);
  if (is_cancelled) preparation->cancel();
  gate.set_value();
  (void)side.make([] { return 0; }).get();  // all that was asked for before is done
  CHECK((textures_there() == before) == is_cancelled);
  for (int i = 0; i < 2; ++i) CHECK((upload.step(array) == SnapshotUpload::Progress::waits) == is_cancelled);
}

TEST_CASE("a picture may come between any two steps, and shows the former snapshot until the last") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const auto atlas = room_atlas(4, {}, {64, 2, 0});
  Renderer renderer({.waiting_bytes = ~std::uint64_t{0}, .allocate_aside = GENERATE(false, true)}), fresh;
  renderer.load(atlas->snapshot());
  for (int round = 0; round < 2; ++round) {
    const Rendering before = renderer.render(kCameraOfSteps, {});
    refine_surface(*atlas, 1);
    invert_photographs(*atlas);
    NextSnapshot next = renderer.begin(atlas->snapshot(), {});
    std::thread worker([&] { next.prepare(); });
    int different = 0;
    while (!renderer.upload(0)) different += renderer.render(kCameraOfSteps, {}).picture.rgb != before.picture.rgb;
    worker.join();
    CHECK(different == 0);
    fresh.load(atlas->snapshot());
    CHECK(renderer.render(kCameraOfSteps, {}).picture.rgb == fresh.render(kCameraOfSteps, {}).picture.rgb);
  }
}

}  // namespace
}  // namespace lumatlas
