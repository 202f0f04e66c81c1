// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures from a store whose surface changes under it: cells that grow, an atlas that follows, a renderer that shows
// it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <glm/glm.hpp>
#include <optional>
#include <random>
#include <vector>

#include "blend/reference.h"
#include "blend/renderer.h"
#include "mesh/cells/cell_growth.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

constexpr std::size_t kViews = 8;

struct Grown {
  std::shared_ptr<const Surface> surface;
  std::vector<CellId> previous_cell;
};

Grown grown(const Surface& before, const Mesh& mesh) {
  CellGrowth growth = grow_cells(before.mesh, before.cells, mesh, match_faces(before.mesh, mesh), {});
  const auto surface = std::make_shared<Surface>();
  surface->mesh = mesh;
  surface->cells = std::move(growth.cells);
  surface->offset = before.offset;
  return {surface, growth.previous_cell};
}

// From places that no stored view was taken from.
std::vector<Rendering> pictures(const Snapshot& snapshot) {
  const auto visibility = make_ray_visibility(snapshot.surface->mesh);
  std::vector<Rendering> renderings;
  for (std::size_t number = 20; number < 26; ++number) {
    const Camera camera = room_camera(number);
    renderings.push_back(render_reference(snapshot, camera, visibility->trace(camera), {}));
  }
  return renderings;
}

bool same(const std::vector<Rendering>& a, const std::vector<Rendering>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Rendering& x, const Rendering& y) {
    return x.picture.rgb == y.picture.rgb && x.state == y.state;
  });
}

std::size_t textured_pixels(const std::vector<Rendering>& renderings) {
  std::size_t pixels = 0;
  for (const Rendering& rendering : renderings) {
    pixels +=
        static_cast<std::size_t>(std::count(rendering.state.begin(), rendering.state.end(), PixelState::textured));
  }
  return pixels;
}

// A wall of 2 x 1 outside of the room, where no camera sees it.
Mesh with_hidden_wall(Mesh mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (int column = 0; column <= 8; ++column) {
    mesh.positions.emplace_back(0.25f * static_cast<float>(column), -5, 0);
    mesh.positions.emplace_back(0.25f * static_cast<float>(column), -5, 1);
  }
  for (std::uint32_t column = 0; column < 8; ++column) {
    const std::uint32_t a = first + 2 * column;
    mesh.faces.insert(mesh.faces.end(), {{a, a + 2, a + 1}, {a + 1, a + 2, a + 3}});
  }
  return mesh;
}

// Without the box that stands in it.
Mesh emptied_room(Mesh mesh) {
  std::erase_if(mesh.faces, [&](const glm::uvec3& face) {
    const glm::vec3 middle = (mesh.positions[face.x] + mesh.positions[face.y] + mesh.positions[face.z]) / 3.0f;
    return glm::all(glm::greaterThan(middle, glm::vec3(1, 1, 0.1f))) &&
           glm::all(glm::lessThan(middle, glm::vec3(3, 3, 1.5f)));
  });
  return mesh;
}

TEST_CASE("a surface that did not change, and one whose faces have another order, show the same pictures") {
  const auto atlas = room_atlas(kViews, {});
  const std::vector<Rendering> before = pictures(atlas->snapshot());
  REQUIRE(textured_pixels(before) > 0);
  Grown next = grown(*atlas->surface(), atlas->surface()->mesh);
  atlas->replace_surface(next.surface, next.previous_cell);
  CHECK(same(pictures(atlas->snapshot()), before));
  Mesh mesh = atlas->surface()->mesh;
  std::shuffle(mesh.faces.begin(), mesh.faces.end(), std::mt19937(3));
  next = grown(*atlas->surface(), mesh);
  atlas->replace_surface(next.surface, next.previous_cell);
  CHECK(same(pictures(atlas->snapshot()), before));
}

TEST_CASE("surface that is added out of view changes no picture, and is forgotten when it goes") {
  const auto atlas = room_atlas(kViews, {});
  const Mesh room = atlas->surface()->mesh;
  const Snapshot first = atlas->snapshot();
  const std::vector<Rendering> before = pictures(first);
  Grown next = grown(*atlas->surface(), with_hidden_wall(room));
  atlas->replace_surface(next.surface, next.previous_cell);
  const Snapshot second = atlas->snapshot();
  CHECK(second.surface->cells.cells.size() > first.surface->cells.cells.size());
  CHECK(same(pictures(second), before));
  next = grown(*atlas->surface(), room);
  atlas->replace_surface(next.surface, next.previous_cell);
  const Snapshot third = atlas->snapshot();
  CHECK(third.references.offsets == first.references.offsets);
  CHECK(third.references.views == first.references.views);
  CHECK(third.cell_seen == first.cell_seen);
  CHECK(third.surface->cells.cell_of_face == first.surface->cells.cell_of_face);
  CHECK(same(pictures(third), before));
}

// The stored views with the depth that the surface gives them now.
void retrace(Atlas& atlas) {
  const auto visibility = make_ray_visibility(atlas.surface()->mesh);
  for (ViewSlot slot{0}; slot < atlas.capacity(); ++slot) {
    const auto view = atlas.view(slot);
    atlas.replace(slot,
                  make_stored_view(view->name, view->camera, view->photograph, visibility->trace(view->camera), {}));
  }
}

TEST_CASE("when a part goes and the views are traced again, the pictures are those of a store of the new surface") {
  const auto atlas = room_atlas(kViews, {});
  const Snapshot full = atlas->snapshot();
  const std::vector<Rendering> before = pictures(full);
  const Grown next = grown(*atlas->surface(), emptied_room(atlas->surface()->mesh));
  REQUIRE(next.surface->cells.cells.size() < full.surface->cells.cells.size());
  Atlas fresh(next.surface, kViews);
  for (ViewSlot slot{0}; slot < kViews; ++slot) fresh.insert(*atlas->view(slot));
  for (CellId cell{0}; cell < next.previous_cell.size(); ++cell) {
    REQUIRE(next.previous_cell[cell] != CellId::none);
    fresh.set_references(cell, atlas->references(next.previous_cell[cell]));
    const CellPixels seen{CellId{cell}, 1};
    if (full.cell_seen[next.previous_cell[cell]]) fresh.mark_seen({&seen, 1});
  }
  retrace(fresh);
  atlas->replace_surface(next.surface, next.previous_cell);
  retrace(*atlas);
  const std::vector<Rendering> after = pictures(atlas->snapshot());
  CHECK(same(after, pictures(fresh.snapshot())));
  CHECK_FALSE(same(after, before));
  CHECK(textured_pixels(after) > 0);
  CHECK(same(pictures(full), before));  // the snapshot taken before still shows the box
}

TEST_CASE("a renderer that follows a surface draws what one draws that has seen no other, to the byte") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const auto atlas = room_atlas(kViews, {});
  const Mesh room = atlas->surface()->mesh;
  Renderer loaded, gradual;
  std::uint64_t meshes = 0;
  const std::vector<Mesh> surfaces{
      with_hidden_wall(room), room, emptied_room(room), with_hidden_wall(emptied_room(room)), room, room};
  for (const Mesh& mesh : surfaces) {
    const Grown next = grown(*atlas->surface(), mesh);
    atlas->replace_surface(next.surface, next.previous_cell);
    retrace(*atlas);
    const Snapshot snapshot = atlas->snapshot();
    loaded.load(snapshot);
    NextSnapshot pieces = gradual.begin(snapshot, {});
    pieces.prepare();
    while (!gradual.upload(0)) {
    }
    Renderer fresh({.join_cells = false});
    fresh.load(snapshot);
    for (std::size_t number = 20; number < 26; ++number) {
      CAPTURE(meshes, number);
      const Rendering right = fresh.render(room_camera(number), {});
      // The first picture joins cells, which changes rounding alone.
      if (meshes == 0) break;
      CHECK(loaded.render(room_camera(number), {}).picture.rgb == right.picture.rgb);
      CHECK(gradual.render(room_camera(number), {}).picture.rgb == right.picture.rgb);
    }
    (void)loaded.render(room_camera(20), {});
    ++meshes;
  }
  CHECK(loaded.work().meshes < surfaces.size());  // the last surface has nothing that is new
  CHECK(gradual.work().meshes < surfaces.size());
}

}  // namespace
}  // namespace lumatlas
