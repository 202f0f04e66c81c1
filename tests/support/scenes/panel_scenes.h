// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes of rectangles, each of one cell with a deviation, that no photograph shows: pictures show their own colours.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <utility>
#include <vector>

#include "atlas/snapshot.h"
#include "mesh/cells/cells.h"

namespace lumatlas {

// A rectangle that faces the camera or leans, of one cell.
struct Panel {
  std::array<glm::vec3, 4> corners;  // left top, right top, left bottom, right bottom
  std::uint8_t grey;                 // at its first corner
  float deviation;
  std::uint8_t more = 0;  // grey at each later corner than at the one before
};

inline Snapshot panel_snapshot(const std::vector<Panel>& of) {
  const auto surface = std::make_shared<Surface>();
  Snapshot snapshot;
  FallbackColors::Colors colors;
  std::vector<CellId> cell_of_face;
  for (const Panel& panel : of) {
    const auto first = static_cast<std::uint32_t>(surface->mesh.positions.size());
    for (std::size_t corner = 0; corner < panel.corners.size(); ++corner) {
      surface->mesh.positions.push_back(panel.corners.at(corner));
      colors.emplace_back(static_cast<std::uint8_t>(panel.grey + corner * panel.more));
    }
    surface->mesh.faces.emplace_back(first, first + 2, first + 1);
    surface->mesh.faces.emplace_back(first + 1, first + 2, first + 3);
    cell_of_face.insert(cell_of_face.end(), 2, CellId{static_cast<std::uint32_t>(snapshot.cell_seen.size())});
    snapshot.cell_seen.push_back(0);
    snapshot.cell_deviation.push_back(panel.deviation);
  }
  surface->cells = measure_cells(surface->mesh, std::move(cell_of_face), 1);
  snapshot.surface = surface;
  snapshot.vertex_colors = std::move(colors);
  snapshot.references.offsets.assign(of.size() + 1, 0);
  return snapshot;
}

inline Panel facing(float left, float right, double depth, std::uint8_t grey, double deviation) {
  const auto z = static_cast<float>(depth);
  return {{glm::vec3(left, -9, z), {right, -9, z}, {left, 9, z}, {right, 9, z}}, grey, static_cast<float>(deviation)};
}

}  // namespace lumatlas
