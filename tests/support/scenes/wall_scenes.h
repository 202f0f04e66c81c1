// SPDX-License-Identifier: GPL-3.0-or-later
// A wall with a panel before it: scenes of a few faces and pixels for tests of the view store and its file.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/base_texture.h"
#include "mesh/camera/camera.h"

namespace lumatlas {

// Looks along +z from `center`.
inline Camera forward_camera(std::uint32_t width, std::uint32_t height, const glm::dvec3& center = glm::dvec3(0)) {
  Camera camera = centered_camera(width, height, width);
  camera.cam_from_world_translation = -center;
  return camera;
}

// Red says the column, green the row, blue `seed` and their parity.
inline Photograph position_photograph(std::uint32_t width, std::uint32_t height, std::uint32_t seed = 0) {
  Photograph photograph{width, height, {}, {}};
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      photograph.rgb.push_back(static_cast<std::uint8_t>(20 + 7 * x));
      photograph.rgb.push_back(static_cast<std::uint8_t>(30 + 11 * y));
      photograph.rgb.push_back(static_cast<std::uint8_t>(90 * (seed % 3) + 40 * ((x + y) % 2)));
    }
  }
  return photograph;
}

// Two triangles for each of `columns` x `rows` squares with the given side, around the z axis at depth z.
inline void add_wall(Mesh& mesh, std::uint32_t columns, std::uint32_t rows, float side, float z) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::uint32_t row = 0; row <= rows; ++row) {
    for (std::uint32_t column = 0; column <= columns; ++column) {
      mesh.positions.emplace_back(side * (static_cast<float>(column) - static_cast<float>(columns) / 2),
                                  side * (static_cast<float>(row) - static_cast<float>(rows) / 2), z);
    }
  }
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const std::uint32_t a = first + row * (columns + 1) + column, b = a + columns + 1;
      mesh.faces.emplace_back(a, b, a + 1);
      mesh.faces.emplace_back(a + 1, b, b + 1);
    }
  }
}

// A wall of 4x4 squares at z = 4 and a panel before its middle at z = 2; `cells` cells of neighbouring faces.
inline std::shared_ptr<const Surface> wall_and_panel(std::uint32_t cells = 5) {
  const auto surface = std::make_shared<Surface>();
  add_wall(surface->mesh, 4, 4, 1, 4);
  add_wall(surface->mesh, 1, 1, 0.5f, 2);
  const std::size_t faces = surface->mesh.faces.size();
  std::vector<CellId> cell_of_face;
  for (std::size_t face = 0; face < faces; ++face) {
    cell_of_face.emplace_back(static_cast<std::uint32_t>(face * cells / faces));
  }
  surface->cells = measure_cells(surface->mesh, std::move(cell_of_face), 1.25);
  surface->offset = {4.5e6, -12.25, 0.1};
  return surface;
}

// Makes a view as the planner does: with depth and validity from the mesh.
inline StoredView traced_view(const Surface& surface, std::string name, const Camera& camera, Photograph photograph,
                              const ValidityOptions& validity = {}, std::vector<std::uint8_t> trust = {}) {
  return make_stored_view(std::move(name), camera, std::move(photograph),
                          make_ray_visibility(surface.mesh)->trace(camera), validity, std::move(trust));
}

// Turned by `angle` (radians) around an oblique axis: numbers with all their digits.
inline Camera oblique_camera(std::uint32_t width, std::uint32_t height, double angle, const glm::dvec3& center) {
  Camera camera = forward_camera(width, height);
  const glm::dmat4 turn = glm::rotate(glm::dmat4(1), angle, glm::dvec3(0.3, 1, -0.2));
  camera.cam_from_world_rotation = glm::dmat3(turn);
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * center);
  camera.fx *= 1.0 / 3 + 0.5;
  camera.cy += 0.1;
  return camera;
}

// A trust mask of many values, all 256 of them from 256 pixels on.
inline std::vector<std::uint8_t> mottled_trust(const Camera& camera) {
  std::vector<std::uint8_t> trust(std::size_t{camera.width} * camera.height);
  for (std::size_t pixel = 0; pixel < trust.size(); ++pixel) trust[pixel] = static_cast<std::uint8_t>(37 * pixel);
  return trust;
}

// Returns a store with free slots between and after three views of different sizes, made with `validity`. One has no
// masks, one a lens mask and a trust mask, one a trust mask. A cell has no references, and no view saw another.
inline Snapshot small_snapshot(const ValidityOptions& validity = {}, const TileOptions& layout = kWholeViews) {
  const auto surface = wall_and_panel(5);
  Atlas atlas(surface, 5, layout);
  const auto insert = [&](const char* name, const Camera& camera, const glm::dvec3& gain, bool lens, bool trust) {
    Photograph photograph = position_photograph(camera.width, camera.height, atlas.size());
    if (lens) {
      photograph.valid.assign(photograph.rgb.size() / 3, 255);
      for (std::size_t pixel = 0; pixel < photograph.valid.size(); pixel += 7) photograph.valid[pixel] = 0;
    }
    TiledView tiled =
        make_tiled_view(name, camera, std::move(photograph), make_ray_visibility(surface->mesh)->trace(camera),
                        surface->cells, layout, validity, trust ? mottled_trust(camera) : std::vector<std::uint8_t>{});
    atlas.set_gain(atlas.insert(std::move(tiled.view), std::move(tiled.shown)), gain);
  };
  insert("a.jpg", oblique_camera(24, 16, 0.1, {0.1, 0.2, -0.3}), {1, 1, 1}, false, false);
  insert("dropped.jpg", forward_camera(8, 8), {3, 3, 3}, false, false);
  insert("left/b.jpg", oblique_camera(20, 18, -0.07, {-0.5, 0, 0.1}), {1.0 / 3, 0.1, 2}, true, true);
  insert("c \u00e9.jpg", forward_camera(30, 30, {0.2, -0.1, -1}), {1.7, 0.9, 1.2}, false, true);
  atlas.erase(1);
  atlas.set_references(0, {0, 2});
  atlas.set_references(1, {3});
  atlas.set_references(3, {3, 0, 2});
  atlas.set_references(4, {2});
  const std::vector<CellPixels> seen{{0, 9}, {1, 9}, {2, 9}, {4, 9}};
  atlas.mark_seen(seen);
  return atlas.snapshot();
}

// Corners where their x and y say, those of every third face in the right half of the image and the others in the left
// one, so that many vertices are in both.
inline BaseTexture small_texture(const Surface& surface) {
  BaseTexture texture;
  texture.image = position_photograph(32, 16);
  const Bounds box = bounds(surface.mesh);
  for (std::size_t face = 0; face < surface.mesh.faces.size(); ++face) {
    std::array<glm::vec2, 3>& places = texture.faces.emplace_back();
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 point(surface.mesh.positions[surface.mesh.faces[face][corner]]);
      const glm::dvec3 share = (point - box.min) / (box.max - box.min);
      places[static_cast<std::size_t>(corner)] = glm::vec2(share.x / 2 + (face % 3 == 0 ? 0.5 : 0.0), share.y);
    }
  }
  return texture;
}

}  // namespace lumatlas
