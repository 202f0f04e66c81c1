// SPDX-License-Identifier: GPL-3.0-or-later
// A renderer that follows a store: what it keeps from one snapshot to the next makes no difference to its pictures.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <optional>

#include "blend/renderer.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

// Returns a snapshot of the same surface, with the first views alone.
Snapshot with_views(const Snapshot& all, std::size_t views) {
  Snapshot snapshot = all;
  for (std::size_t slot = views; slot < snapshot.views.size(); ++slot) snapshot.views[slot].reset();
  snapshot.references.views.clear();
  snapshot.references.offsets.assign(1, 0);
  for (std::size_t cell = 0; cell + 1 < all.references.offsets.size(); ++cell) {
    for (const ViewSlot slot : all.references.of_cell(static_cast<std::uint32_t>(cell))) {
      if (slot < views) snapshot.references.views.push_back(slot);
    }
    snapshot.references.offsets.push_back(static_cast<std::uint32_t>(snapshot.references.views.size()));
  }
  FallbackColors::Colors colors(snapshot.vertex_colors.size());
  for (std::size_t vertex = 0; vertex < colors.size(); ++vertex) {
    colors[vertex] = glm::u8vec3(views, 2 * views, vertex % 256);
  }
  snapshot.vertex_colors = std::move(colors);
  return snapshot;
}

TEST_CASE("pictures of a store that changes are those of a renderer that never saw it before") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot all = room_snapshot(10, {});
  Renderer following;
  for (const std::size_t views : {3u, 4u, 10u, 10u, 5u}) {
    CAPTURE(views);
    const Snapshot snapshot = with_views(all, views);
    following.load(snapshot);
    Renderer fresh({.join_cells = false});
    fresh.load(snapshot);
    for (const double border : {0.1, 0.0, 0.1}) {
      BlendOptions options;
      options.border_width = border;
      const Camera camera = room_camera(2);
      const Rendering kept = following.render(camera, options);
      const Rendering made = fresh.render(camera, options);
      // The first picture joins cells, which changes rounding alone.
      std::size_t different = 0;
      for (std::size_t i = 0; i < kept.picture.rgb.size(); ++i) {
        different += std::abs(int{kept.picture.rgb[i]} - int{made.picture.rgb[i]}) > (views == 3 ? 1 : 0);
      }
      CHECK(different <= (views == 3 ? kept.picture.rgb.size() / 1000 : 0));
      CHECK(kept.state == made.state);
    }
  }
}

TEST_CASE("a store whose surface is another one is loaded anew") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot first = room_snapshot(4, {});
  Snapshot second = room_snapshot(6, {});
  REQUIRE(first.surface != second.surface);
  Renderer renderer;
  renderer.load(first);
  (void)renderer.render(room_camera(1), {});
  renderer.load(second);
  Renderer fresh;
  fresh.load(second);
  CHECK(renderer.render(room_camera(1), {}).picture.rgb == fresh.render(room_camera(1), {}).picture.rgb);
}

}  // namespace
}  // namespace lumatlas
