// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/scenes/small_scenes.h"

#include <cmath>
#include <glm/glm.hpp>
#include <utility>

#include "mesh/cells/cells.h"
#include "mesh/cells/split_faces.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

namespace {

// Adds the six sides of a box.
void add_box(Mesh& mesh, const glm::vec3& low, const glm::vec3& high) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (int corner = 0; corner < 8; ++corner) {
    mesh.positions.emplace_back(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z);
  }
  const glm::uvec4 sides[] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const glm::uvec4& side : sides) {
    mesh.faces.push_back(first + glm::uvec3(side.x, side.y, side.z));
    mesh.faces.push_back(first + glm::uvec3(side.x, side.z, side.w));
  }
}

}  // namespace

std::shared_ptr<const Surface> room_surface() {
  Mesh mesh;
  add_box(mesh, {0, 0, 0}, {4, 4, 3});
  add_box(mesh, {1.6f, 1.5f, 0.2f}, {2.3f, 2.4f, 1.1f});
  CellOptions options;
  options.size = 0.5;
  const auto surface = std::make_shared<Surface>();
  surface->mesh = split_large_faces(mesh, options.size);
  surface->cells = make_cells(surface->mesh, options);
  return surface;
}

Camera room_camera(std::size_t number) {
  const double turn = 0.7 * static_cast<double>(number);
  const glm::dvec3 center(2 + 1.4 * std::cos(0.31 * turn), 2 + 1.3 * std::sin(0.31 * turn), 1.7 + 0.6 * std::sin(turn));
  const glm::dvec3 forward = glm::normalize(glm::dvec3(std::cos(turn), std::sin(turn), 0.4 * std::cos(1.7 * turn)));
  const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
  const glm::dvec3 down = glm::cross(forward, right);
  Camera camera;
  camera.width = 96;
  camera.height = 72;
  camera.fx = 70;
  camera.fy = 72;
  camera.cx = 47;
  camera.cy = 37;
  camera.cam_from_world_rotation = glm::transpose(glm::dmat3(right, down, forward));
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * center);
  return camera;
}

Photograph pattern_photograph(const Camera& camera, std::size_t seed) {
  Photograph photograph;
  photograph.width = camera.width;
  photograph.height = camera.height;
  for (std::uint32_t y = 0; y < camera.height; ++y) {
    for (std::uint32_t x = 0; x < camera.width; ++x) {
      const double wave = std::sin(0.21 * x + 0.13 * y + static_cast<double>(seed));
      photograph.rgb.push_back(static_cast<std::uint8_t>(30 + 200 * x / camera.width));
      photograph.rgb.push_back(static_cast<std::uint8_t>(30 + 200 * y / camera.height));
      photograph.rgb.push_back(static_cast<std::uint8_t>(128 + 90 * wave));
    }
  }
  return photograph;
}

std::unique_ptr<Atlas> room_atlas(std::size_t views, const ValidityOptions& options, const TileOptions& layout,
                                  TilePolicy policy) {
  const auto surface = room_surface();
  const auto visibility = make_ray_visibility(surface->mesh);
  auto atlas = std::make_unique<Atlas>(surface, static_cast<std::uint32_t>(views), layout, std::move(policy));
  std::vector<std::vector<ViewSlot>> references(surface->cells.cells.size());
  for (std::size_t number = 0; number < views; ++number) {
    const Camera camera = room_camera(number);
    VisibilityBuffer visible = visibility->trace(camera);
    const std::vector<CellPixels> seen = count_cell_pixels(visible, surface->cells);
    atlas->mark_seen(seen);
    TiledView tiled = make_tiled_view("view " + std::to_string(number), camera, pattern_photograph(camera, number),
                                      std::move(visible), surface->cells, layout, options);
    const ViewSlot slot = atlas->insert(std::move(tiled.view), std::move(tiled.shown));
    for (const CellPixels& cell : seen) references[cell.cell].push_back(slot);
  }
  for (CellId cell{0}; cell < references.size(); ++cell) atlas->set_references(cell, references[cell]);
  return atlas;
}

Snapshot room_snapshot(std::size_t views, const ValidityOptions& options, const TileOptions& layout,
                       TilePolicy policy) {
  return room_atlas(views, options, layout, std::move(policy))->snapshot();
}

Snapshot exposed_room_snapshot(std::size_t views) {
  Snapshot snapshot = room_snapshot(views, {});
  for (std::size_t slot = 0; slot < views; ++slot) {
    snapshot.gains[slot] = glm::dvec3(0.6 + 0.1 * static_cast<double>(slot));
  }
  return snapshot;
}

}  // namespace lumatlas
