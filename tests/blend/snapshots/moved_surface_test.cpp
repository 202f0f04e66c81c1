// SPDX-License-Identifier: GPL-3.0-or-later
// A surface that moves together with the views, as after a loop closure, on its way to a renderer piece by piece.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "blend/renderer.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

constexpr std::size_t kRoomViews = 8;
constexpr TileOptions kRoomTiles{16, 2, 0};

void take_next(Renderer& renderer, const Snapshot& snapshot) {
  NextSnapshot next = renderer.begin(snapshot, {});
  std::thread worker([&next] { next.prepare(); });
  while (!renderer.upload(0)) {
  }
  worker.join();
}

// Turns the scene by a quarter about the third axis, which rounds nothing, and shifts it.
glm::dvec3 moved(const glm::dvec3& place) {
  return {4 - place.y, place.x + 8, place.z - 2};
}

Camera moved(Camera camera) {
  const glm::dvec3 center = moved(camera.center());
  const glm::dmat3 turn(0, 1, 0, -1, 0, 0, 0, 0, 1);
  camera.cam_from_world_rotation = camera.cam_from_world_rotation * glm::transpose(turn);
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * center);
  return camera;
}

void move_scene(Atlas& atlas) {
  const auto surface = std::make_shared<Surface>(*atlas.surface());
  for (glm::vec3& position : surface->mesh.positions) position = moved(glm::dvec3(position));
  surface->cells = measure_cells(surface->mesh, surface->cells.cell_of_face, surface->cells.size);
  std::vector<CellId> same;
  for (CellId cell{0}; cell < surface->cells.cells.size(); ++cell) same.push_back(cell);
  std::vector<ViewPose> poses;
  for (ViewSlot slot{0}; slot < kRoomViews; ++slot) poses.push_back({slot, moved(atlas.view(slot)->camera)});
  atlas.replace_surface(surface, same, poses);
}

// Returns how many pixels differ by more than rounding does.
std::size_t pixels_apart(const Photograph& a, const Photograph& b) {
  REQUIRE(a.rgb.size() == b.rgb.size());
  std::size_t apart = 0;
  for (std::size_t i = 0; i < a.rgb.size(); i += 3) {
    int most = 0;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      most = std::max(most, std::abs(int{a.rgb[i + channel]} - int{b.rgb[i + channel]}));
    }
    apart += most > 2 ? 1 : 0;
  }
  return apart;
}

TEST_CASE("a surface that moves with its views is shown in its place without being laid out again") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const auto atlas = room_atlas(kRoomViews, {}, kRoomTiles);
  std::vector<ViewSlot> fewer = atlas->references(CellId{0});
  if (!fewer.empty()) fewer.pop_back();
  Renderer renderer;
  renderer.load(atlas->snapshot());
  atlas->set_references(CellId{0}, fewer);
  take_next(renderer, atlas->snapshot());
  std::vector<Photograph> before;
  for (std::size_t number = 20; number < 26; ++number) {
    before.push_back(renderer.render(room_camera(number), {}).picture);
  }
  const std::uint64_t meshes = renderer.work().meshes;
  const std::uint64_t colors = renderer.work().color_bytes;
  move_scene(*atlas);
  take_next(renderer, atlas->snapshot());
  Renderer anew({.join_cells = false});  // as those of a store that has changed
  anew.load(atlas->snapshot());
  for (std::size_t number = 20; number < 26; ++number) {
    CAPTURE(number);
    const Photograph picture = renderer.render(moved(room_camera(number)), {}).picture;
    const std::size_t pixels = picture.rgb.size() / 3;
    CHECK(pixels_apart(picture, before[number - 20]) < pixels / 200);
    // Faces of the room are as far from several cells, and rounding decides between them.
    CHECK(pixels_apart(picture, anew.render(moved(room_camera(number)), {}).picture) < pixels / 20);
  }
  CHECK(renderer.work().meshes == meshes);
  BlendOptions alone;  // each pixel shows its own cell
  alone.border_width = 0;
  for (std::size_t number = 20; number < 26; ++number) {
    const Camera camera = moved(room_camera(number));
    CHECK(pixels_apart(renderer.render(camera, alone).picture, anew.render(camera, alone).picture) == 0);
  }
  CHECK(renderer.work().color_bytes == colors);
}

TEST_CASE("the colours of a surface that has moved are those of before, until the next snapshot brings them") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const auto atlas = room_atlas(kRoomViews, {}, kRoomTiles);
  Renderer renderer;
  renderer.load(atlas->snapshot());
  // No photograph is shown anywhere, so that pictures show the mesh's colours alone.
  for (CellId cell{0}; cell < atlas->surface()->cells.cells.size(); ++cell) atlas->set_references(cell, {});
  take_next(renderer, atlas->snapshot());
  const Camera camera = room_camera(21);
  BlendOptions options;
  options.exposure = BlendOptions::Exposure::model;
  const Photograph before = renderer.render(camera, options).picture;
  move_scene(*atlas);
  for (ViewSlot slot{0}; slot < kRoomViews; ++slot) atlas->set_gain(slot, {0.25, 0.5, 1});
  const Snapshot snapshot = atlas->snapshot();
  take_next(renderer, snapshot);
  const Photograph between = renderer.render(moved(camera), options).picture;
  Renderer anew({.join_cells = false});  // as those of a store that has changed
  anew.load(snapshot);
  const Photograph later = anew.render(moved(camera), options).picture;
  CHECK(pixels_apart(between, later) > later.rgb.size() / 3 / 4);
  take_next(renderer, snapshot);
  CHECK(pixels_apart(renderer.render(moved(camera), options).picture, later) == 0);
  CHECK(pixels_apart(between, before) < before.rgb.size() / 3 / 50);
}

}  // namespace
}  // namespace lumatlas
