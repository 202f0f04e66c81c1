// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/visibility/visibility.h"

#include <cstddef>
#include <stdexcept>
#include <string>

#include "mesh/base/number_text.h"

namespace lumatlas {

void require_one_per_pixel(std::span<const std::uint8_t> wanted, const Camera& camera) {
  if (wanted.size() == std::size_t{camera.width} * camera.height) return;
  throw std::invalid_argument("visibility: wanted has " + std::to_string(wanted.size()) +
                              " values, must have one per pixel of " + size_text(camera.width, camera.height));
}

VisibilityBuffer Visibility::trace(const Camera& camera) const {
  VisibilityBuffer buffer;
  trace(camera, buffer);
  return buffer;
}

void Visibility::trace_sparsely(const Camera& camera, VisibilityBuffer& buffer) const {
  trace(camera, buffer);
}

VisibilityBuffer Visibility::trace_sparsely(const Camera& camera) const {
  VisibilityBuffer buffer;
  trace_sparsely(camera, buffer);
  return buffer;
}

void Visibility::trace_wanted(const Camera& camera, std::span<const std::uint8_t> wanted,
                              VisibilityBuffer& buffer) const {
  require_one_per_pixel(wanted, camera);
  trace(camera, buffer);
}

std::vector<CellPixels> count_cell_pixels(const VisibilityBuffer& buffer, const Cells& cells) {
  std::vector<std::uint32_t> pixels_of_cell(cells.cells.size(), 0);
  for (const std::uint32_t face : buffer.face) {
    if (face == FaceId::none) continue;
    if (face >= cells.cell_of_face.size()) {
      throw std::invalid_argument("visibility: the buffer shows face " + std::to_string(face) +
                                  ", must be below the number of faces in cells, " +
                                  std::to_string(cells.cell_of_face.size()));
    }
    const CellId cell = cells.cell_of_face[face];
    if (cell >= pixels_of_cell.size()) {
      throw std::invalid_argument("cells: cell_of_face[" + std::to_string(face) + "] is " + std::to_string(cell) +
                                  ", must be below the number of cells, " + std::to_string(pixels_of_cell.size()));
    }
    ++pixels_of_cell[cell];
  }
  std::vector<CellPixels> counts;
  for (CellId cell{0}; cell < pixels_of_cell.size(); ++cell) {
    if (pixels_of_cell[cell] > 0) counts.push_back({CellId{cell}, pixels_of_cell[cell]});
  }
  return counts;
}

}  // namespace lumatlas
