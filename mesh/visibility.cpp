// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/visibility.h"

namespace lumatlas {

VisibilityBuffer Visibility::trace(const Camera& camera) const {
  VisibilityBuffer buffer;
  trace(camera, buffer);
  return buffer;
}

std::vector<CellPixels> count_cell_pixels(const VisibilityBuffer& buffer, const Cells& cells) {
  std::vector<std::uint32_t> pixels_of_cell(cells.cells.size(), 0);
  for (const std::uint32_t face : buffer.face) {
    if (face != kNoFace) ++pixels_of_cell[cells.cell_of_face[face]];
  }
  std::vector<CellPixels> counts;
  for (std::uint32_t cell = 0; cell < pixels_of_cell.size(); ++cell) {
    if (pixels_of_cell[cell] > 0) counts.push_back({cell, pixels_of_cell[cell]});
  }
  return counts;
}

}  // namespace lumatlas
