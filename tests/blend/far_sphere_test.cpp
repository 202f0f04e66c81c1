// SPDX-License-Identifier: GPL-3.0-or-later
// The far sphere is blended by direction, the same by both renderers, without a line where a photograph ends. White in
// a photograph stays white.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <glm/gtc/matrix_transform.hpp>

#include "blend/exposure.h"
#include "blend/reference.h"
#include "blend/renderer.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/far_scenes.h"

namespace lumatlas {
namespace {

Photograph level_photograph(const Camera& camera, std::uint8_t level) {
  return {
      camera.width, camera.height, std::vector<std::uint8_t>(3 * std::size_t{camera.width} * camera.height, level), {}};
}

Camera turned_camera(double degrees, std::uint32_t width = 120, std::uint32_t height = 90) {
  Camera camera = forward_camera(width, height);
  camera.cam_from_world_rotation = glm::dmat3(glm::rotate(glm::dmat4(1), glm::radians(degrees), glm::dvec3(0, 1, 0)));
  return camera;
}

// A view of a far sphere with a small panel before it. Its camera is turned by `degrees` around the y axis, and all
// pixels of its photograph have the sRGB value `level`.
struct FarView {
  double degrees;
  std::uint8_t level;
  double gain = 1;
};
Snapshot far_snapshot_of(const std::vector<FarView>& views) {
  auto near = std::make_shared<Surface>();
  add_wall(near->mesh, 1, 1, 0.5f, 4);
  near->cells = measure_cells(near->mesh, {0, 0}, 0.5);
  const auto surface = with_sphere_behind(*near);
  Atlas atlas(surface, static_cast<std::uint32_t>(views.size()));
  std::vector<ViewSlot> slots;
  for (const FarView& view : views) {
    const Camera camera = turned_camera(view.degrees);
    slots.push_back(atlas.insert(traced_view(*surface, "", camera, level_photograph(camera, view.level))));
    atlas.set_gain(slots.back(), glm::dvec3(view.gain));
  }
  std::vector<CellPixels> seen;
  for (CellId cell{0}; cell < surface->cells.cells.size(); ++cell) {
    atlas.set_references(cell, slots);
    seen.push_back({CellId{cell}, 1});
  }
  atlas.mark_seen(seen);
  return atlas.snapshot();
}

Rendering far_by_reference(const Snapshot& snapshot, const Camera& camera, const BlendOptions& options = {}) {
  return render_reference(snapshot, camera, *make_ray_visibility(snapshot.surface->mesh), options);
}

Rendering far_by_shader(const Snapshot& snapshot, const Camera& camera, const BlendOptions& options = {}) {
  Renderer renderer;
  renderer.load(snapshot);
  return renderer.render(camera, options);
}

int largest_step_in_rows(const Photograph& picture) {
  int largest = 0;
  for (std::size_t y = 0; y < picture.height; ++y) {
    for (std::size_t x = 1; x < picture.width; ++x) {
      const std::size_t pixel = 3 * (y * picture.width + x);
      largest = std::max(largest, std::abs(picture.rgb[pixel] - picture.rgb[pixel - 3]));
    }
  }
  return largest;
}

TEST_CASE("photographs of what is far fade into each other over half of their width") {
  const Snapshot snapshot = far_snapshot_of({{-12, 80}, {12, 160}});
  // Above the panel, where both photographs show the sphere; 60 columns see the photographs' overlap.
  Camera camera = forward_camera(240, 20);
  camera.fx = camera.fy = 480;
  camera.cy = 80;
  const Rendering rendering = far_by_reference(snapshot, camera);
  CHECK(std::count(rendering.state.begin(), rendering.state.end(), PixelState::textured) == 240 * 20);
  CHECK(largest_step_in_rows(rendering.picture) <= 4);
  const auto [low, high] = std::minmax_element(rendering.picture.rgb.begin(), rendering.picture.rgb.end());
  CHECK(*high - *low > 40);
}

TEST_CASE("both renderers draw the far sphere alike") {
  const auto context = context_or_skip();
  if (!context) return;
  const Snapshot snapshot = far_snapshot_of({{-25, 60, 0.8}, {-5, 90, 1.1}, {10, 200, 1}, {30, 255, 0.6}});
  for (const double degrees : {-20.0, 0.0, 17.0}) {
    const Camera camera = turned_camera(degrees);
    const Rendering expected = far_by_reference(snapshot, camera), drawn = far_by_shader(snapshot, camera);
    std::size_t differ = 0;
    for (std::size_t value = 0; value < expected.picture.rgb.size(); ++value) {
      if (std::abs(expected.picture.rgb[value] - drawn.picture.rgb[value]) > 2) ++differ;
    }
    CHECK(differ < expected.picture.rgb.size() / 100);
  }
}

TEST_CASE("what is white in a photograph stays white, whatever the photograph's gain") {
  const glm::dvec3 darker(0.5), white(1), grey(0.5), brighter(2);
  CHECK(shown_gain(darker, grey, white) == darker);
  CHECK(shown_gain(darker, white, white) == white);
  CHECK(shown_gain(brighter, white, white) == brighter);
  CHECK((shown_gain(darker, white, brighter) * brighter).x >= 1);
  const glm::dvec3 nearly(kClippedFrom);
  CHECK(shown_gain(darker, nearly, white) == darker);
  // In a picture that is exposed as the other photograph was.
  const Snapshot snapshot = far_snapshot_of({{0, 255, 0.3}, {0, 250, 1}});
  BlendOptions options;
  options.exposure = BlendOptions::Exposure::model;
  const Rendering rendering = far_by_reference(snapshot, turned_camera(0), options);
  // All but the panel's silhouette, where neither photograph is valid.
  const auto& rgb = rendering.picture.rgb;
  const auto white_values = std::count_if(rgb.begin(), rgb.end(), [](std::uint8_t value) { return value >= 249; });
  CHECK(100 * static_cast<std::size_t>(white_values) > 95 * rgb.size());
}

}  // namespace
}  // namespace lumatlas
