// SPDX-License-Identifier: GPL-3.0-or-later
// Counts the work that a renderer which follows a store does again.
#include <catch2/catch.hpp>
#include <numeric>
#include <optional>
#include <vector>

#include "blend/renderer.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/view_parts.h"

namespace lumatlas {
namespace {

// A store of a room, and a renderer that follows it.
struct Followed {
  explicit Followed(const TileOptions& layout = kWholeViews) : atlas(room_atlas(6, {}, layout)) { show(); }

  // Returns the renderer's work for the store as it is now.
  RendererWork show() {
    const RendererWork before = renderer.work();
    renderer.load(atlas->snapshot());
    picture = renderer.render(room_camera(2), {});
    const RendererWork now = renderer.work();
    return {now.meshes - before.meshes, now.color_bytes - before.color_bytes, now.mask_bytes - before.mask_bytes,
            now.depth_bytes - before.depth_bytes};
  }

  // Takes a view's references out of a cell that has some.
  void refer_to_less(CellId cell) const {
    std::vector<ViewSlot> slots = atlas->references(cell);
    if (!slots.empty()) slots.pop_back();
    atlas->set_references(cell, slots);
  }

  // Replaces the surface by an equal one at another address.
  void replace_surface() const {
    const auto next = std::make_shared<const Surface>(*atlas->surface());
    std::vector<CellId> same_cells;
    for (CellId cell{0}; cell < next->cells.cells.size(); ++cell) same_cells.emplace_back(cell);
    atlas->replace_surface(next, same_cells);
  }

  // The view of slot 4 as `change` leaves it.
  template <typename Change>
  void change_view(const Change& change) const {
    StoredView view = *atlas->view(4);
    change(view);
    atlas->replace(4, std::move(view), *atlas->shown(4));
  }

  // Returns whether the picture is that of a new renderer.
  [[nodiscard]] bool is_exact() const {
    Renderer fresh({.join_cells = false});
    fresh.load(atlas->snapshot());
    return fresh.render(room_camera(2), {}).picture.rgb == picture.picture.rgb;
  }

  std::unique_ptr<Atlas> atlas;
  Renderer renderer;
  Rendering picture;
};

constexpr TileOptions kTiles{16, 2, 0};

TEST_CASE("the mesh stays for a later surface with the same faces, however often the store changes") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Followed followed;
  followed.refer_to_less(0);
  CHECK(followed.show().meshes <= 1);  // of the first surface cells may have been joined
  for (int surface = 0; surface < 3; ++surface) {
    followed.replace_surface();
    CHECK(followed.show().meshes == 0);
    for (CellId cell{1}; cell < 4; ++cell) {
      followed.refer_to_less(cell);
      CHECK(followed.show().meshes == 0);
    }
    CHECK(followed.is_exact());
  }
}

TEST_CASE("a new pose, or new depths, upload no photograph") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Followed followed(kTiles);
  CHECK(followed.show().color_bytes == 0);
  followed.change_view([](StoredView& view) { view.camera.cam_from_world_translation.x += 1e-3; });
  const RendererWork of_pose = followed.show();
  CHECK(of_pose.color_bytes == 0);
  CHECK(of_pose.mask_bytes == 0);
  CHECK(of_pose.depth_bytes == 0);
  followed.refer_to_less(0);
  (void)followed.show();
  CHECK(followed.is_exact());
  followed.change_view([](StoredView& view) {
    for (float& depth : own_mask(view).depth.values()) depth *= 1.01F;
  });
  const RendererWork of_depths = followed.show();
  CHECK(of_depths.color_bytes == 0);
  CHECK(of_depths.mask_bytes == 0);
  CHECK(of_depths.depth_bytes > 0);
  CHECK(followed.is_exact());
}

TEST_CASE("what is in a slot again is known by its bytes") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Followed followed(kTiles);
  followed.change_view([](StoredView& view) { change_colors(view, [](std::uint8_t value) { return value ^ 1; }); });
  CHECK(followed.show().color_bytes > 0);
  followed.change_view([](StoredView& view) { view.name = "the same photograph"; });
  CHECK(followed.show().color_bytes == 0);
  followed.refer_to_less(0);
  (void)followed.show();
  CHECK(followed.is_exact());
}

TEST_CASE("a new mask uploads masks and no photograph") {
  const TileOptions layout = GENERATE(as<TileOptions>(), kTiles, TileOptions{64, 8, 0}, kWholeViews);
  const bool embedded = GENERATE(false, true);
  CAPTURE(layout.tile_px, embedded);
  const std::optional<EglContext> context = context_or_skip({.debug = true, .embedded = embedded});
  if (!context) return;
  Followed followed(layout);
  const auto halve_validity = [&] {
    followed.change_view([](StoredView& view) {
      std::vector<std::uint8_t>& validity = own_mask(view).validity.values();
      for (std::size_t pixel = 0; pixel < validity.size(); pixel += 2) {
        if (validity[pixel] > 1) validity[pixel] /= 2;  // what is valid stays valid
      }
    });
    return followed.show();
  };
  CHECK(halve_validity().color_bytes == 0);
  const RendererWork of_mask = halve_validity();
  CHECK(of_mask.color_bytes == 0);
  CHECK(of_mask.mask_bytes > 0);
  CHECK(of_mask.depth_bytes == 0);  // what is whole, what is valid and how deep it lies is as before
  followed.refer_to_less(0);
  (void)followed.show();
  CHECK(followed.is_exact());
  followed.change_view([](StoredView& view) {
    std::vector<std::uint8_t>& validity = own_mask(view).validity.values();
    std::fill_n(validity.begin(), validity.size() / 2, std::uint8_t{0});
  });
  const RendererWork of_less = followed.show();
  CHECK(of_less.color_bytes == 0);
  CHECK(of_less.mask_bytes > 0);
  CHECK(of_less.depth_bytes > 0);
  CHECK(followed.is_exact());
  CHECK(followed.show().mask_bytes == 0);
}

}  // namespace
}  // namespace lumatlas
