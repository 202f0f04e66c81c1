// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/bench/sheet_store.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <string>
#include <utility>
#include <vector>

namespace lumatlas {

namespace {

constexpr std::uint32_t kQuadsOfCell = 20;  // across a cell

}  // namespace

std::shared_ptr<const Surface> hilly_sheet(std::uint32_t vertices, double height) {
  const auto surface = std::make_shared<Surface>();
  const auto quads = static_cast<std::uint32_t>(std::ceil(std::sqrt(vertices))) - 1;
  for (std::uint32_t j = 0; j <= quads; ++j) {
    for (std::uint32_t i = 0; i <= quads; ++i) {
      const double x = static_cast<double>(i) / quads, y = static_cast<double>(j) / quads;
      surface->mesh.positions.emplace_back(x, y, height * std::sin(31 * x) * std::sin(23 * y));
    }
  }
  const std::uint32_t columns = (quads + kQuadsOfCell - 1) / kQuadsOfCell;
  std::vector<CellId> cell_of_face;
  for (std::uint32_t j = 0; j < quads; ++j) {
    for (std::uint32_t i = 0; i < quads; ++i) {
      const std::uint32_t a = j * (quads + 1) + i, c = a + quads + 2;
      surface->mesh.faces.insert(surface->mesh.faces.end(), {{a, a + 1, c}, {a, c, c - 1}});
      cell_of_face.insert(cell_of_face.end(), 2, CellId(j / kQuadsOfCell * columns + i / kQuadsOfCell));
    }
  }
  surface->cells =
      measure_cells(surface->mesh, std::move(cell_of_face), static_cast<double>(kQuadsOfCell) / std::max(quads, 1u));
  return surface;
}

Camera camera_above(double x, double y, double across, std::uint32_t width, std::uint32_t height) {
  Camera camera = centered_camera(width, height, width);
  camera.cam_from_world_rotation = glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1);
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * glm::dvec3(x, y, across));
  return camera;
}

Photograph noise(std::uint32_t width, std::uint32_t height, std::uint32_t seed) {
  Photograph photograph{width, height, {}, {}};
  photograph.rgb.resize(std::size_t{3} * width * height);
  for (std::uint8_t& value : photograph.rgb) {
    seed = seed * 1664525 + 1013904223;
    value = static_cast<std::uint8_t>(seed >> 24);
  }
  return photograph;
}

std::unique_ptr<Atlas> sheet_store(const std::shared_ptr<const Surface>& surface, const Visibility& visibility,
                                   std::span<const Camera> cameras, std::size_t references) {
  auto atlas = std::make_unique<Atlas>(surface, static_cast<std::uint32_t>(cameras.size()), kSheetLayout);
  std::vector<std::vector<ViewSlot>> of_cells(surface->cells.cells.size());
  for (const Camera& camera : cameras) {
    VisibilityBuffer visible = visibility.trace_sparsely(camera);
    const std::vector<CellPixels> cells = count_cell_pixels(visible, surface->cells);
    TiledView tiled = make_tiled_view("view " + std::to_string(atlas->size()), camera,
                                      noise(camera.width, camera.height, atlas->size()), std::move(visible),
                                      surface->cells, kSheetLayout, {});
    const ViewSlot slot = atlas->insert(std::move(tiled.view), std::move(tiled.shown));
    for (const CellPixels& seen : cells) {
      if (of_cells[seen.cell].size() < references) of_cells[seen.cell].push_back(slot);
    }
  }
  for (CellId cell{0}; cell < of_cells.size(); ++cell) atlas->set_references(cell, std::move(of_cells[cell]));
  return atlas;
}

}  // namespace lumatlas
