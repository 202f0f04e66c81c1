// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs of a flat wall whose colours are known, over a mesh that stands a known distance before it.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/gtc/quaternion.hpp>
#include <glm/trigonometric.hpp>
#include <memory>
#include <utility>
#include <vector>

#include "atlas/atlas.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {

inline constexpr double kWallDepth = 4;      // of the true wall, scene units
inline constexpr std::uint32_t kSide = 200;  // pixels of a photograph

// Brightness of the wall at a place, of 255.
using WallPaint = std::function<double(double x, double y)>;

// Between random values at the corners of a lattice of 0.06 scene units, 3 pixels.
inline double speckled(double x, double y) {
  const auto corner = [](double column, double row) {
    const double number = std::sin(column * 127.1 + row * 311.7) * 43758.5453;
    return 255 * (number - std::floor(number));
  };
  const double column = std::floor(x / 0.06), row = std::floor(y / 0.06);
  const double across = x / 0.06 - column, down = y / 0.06 - row;
  return (1 - down) * ((1 - across) * corner(column, row) + across * corner(column + 1, row)) +
         down * ((1 - across) * corner(column, row + 1) + across * corner(column + 1, row + 1));
}

inline double grey(double /*x*/, double /*y*/) {
  return 128;
}

// `degrees` beside the middle of the wall, four scene units away from it, looking there.
inline Camera beside(double degrees) {
  Camera camera = forward_camera(kSide, kSide);
  const double angle = glm::radians(degrees);
  const glm::dvec3 center(kWallDepth * std::sin(angle), 0, kWallDepth * (1 - std::cos(angle)));
  camera.cam_from_world_rotation = glm::mat3_cast(glm::angleAxis(angle, glm::dvec3(0, 1, 0)));
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * center);
  return camera;
}

inline Photograph photograph_of(const WallPaint& paint, const Camera& camera) {
  Photograph photograph{camera.width, camera.height, {}, {}};
  for (std::uint32_t y = 0; y < camera.height; ++y) {
    for (std::uint32_t x = 0; x < camera.width; ++x) {
      const glm::dvec3 ray = camera.ray({x + 0.5, y + 0.5});
      const glm::dvec3 place = camera.center() + (kWallDepth - camera.center().z) / ray.z * ray;
      photograph.rgb.insert(photograph.rgb.end(), 3, static_cast<std::uint8_t>(std::lround(paint(place.x, place.y))));
    }
  }
  return photograph;
}

// A wall of 4 x 4 cells, `before` the true one, towards the cameras.
inline std::shared_ptr<const Surface> wall_before(double before) {
  auto surface = std::make_shared<Surface>();
  add_wall(surface->mesh, 16, 16, 0.125f, static_cast<float>(kWallDepth - before));
  std::vector<CellId> cell_of_face;
  for (std::uint32_t face = 0; face < 2 * 16 * 16; ++face) {
    const std::uint32_t square = face / 2;
    cell_of_face.emplace_back(square % 16 / 4 + 4 * (square / 16 / 4));
  }
  surface->cells = measure_cells(surface->mesh, std::move(cell_of_face), 0.5);
  return surface;
}

// The cameras from which the wall is photographed: 8 degrees apart.
inline std::vector<Camera> cameras_before_wall() {
  return {beside(-8), beside(0), beside(8)};
}

// Every cell refers to every photograph. `noted`: the cameras with which the photographs are stored.
inline Snapshot photographed(const std::shared_ptr<const Surface>& surface, const std::vector<WallPaint>& paints,
                             const std::vector<Camera>& noted = cameras_before_wall()) {
  const std::vector<Camera> taken_by = cameras_before_wall();
  Atlas atlas(surface, 3);
  std::vector<ViewSlot> slots;
  for (std::size_t i = 0; i < paints.size(); ++i) {
    slots.push_back(atlas.insert(traced_view(*surface, "", noted[i], photograph_of(paints[i], taken_by[i]))));
  }
  for (CellId cell{0}; cell < surface->cells.cells.size(); ++cell) atlas.set_references(cell, slots);
  return atlas.snapshot();
}

inline Snapshot photographed(const std::shared_ptr<const Surface>& surface, const WallPaint& paint) {
  return photographed(surface, std::vector<WallPaint>(3, paint));
}

}  // namespace lumatlas
