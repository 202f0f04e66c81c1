// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/tables/cell_runs.h"

#include <stdexcept>
#include <string>

#include "blend/tables/view_pyramid.h"

namespace lumatlas {

CellRuns::CellRuns(const Cells& cells, std::size_t faces) {
  if (cells.cell_of_face.size() != faces) {
    throw std::invalid_argument("cells: they have " + std::to_string(cells.cell_of_face.size()) +
                                " faces, must have the mesh's " + std::to_string(faces));
  }
  std::vector<std::uint32_t> counts(cells.cells.size(), 0);
  for (std::size_t face = 0; face < faces; ++face) {
    const CellId cell = cells.cell_of_face[face];
    if (cell >= counts.size()) {
      throw std::invalid_argument("cells: face " + std::to_string(face) + " is in cell " + std::to_string(cell) +
                                  ", must be below the number of cells, " + std::to_string(counts.size()));
    }
    ++counts[cell];
  }
  for (std::size_t cell = 0; cell < counts.size(); ++cell) {
    if (cells.cells[cell].faces == counts[cell]) continue;
    throw std::invalid_argument("cells: cell " + std::to_string(cell) + " says that it has " +
                                std::to_string(cells.cells[cell].faces) + " faces, but " +
                                std::to_string(counts[cell]) + " are in it");
  }
  first_of_cell_.push_back(0);
  for (const Cell& cell : cells.cells) {
    spheres_.push_back({cell.centroid, cell.radius});
    first_of_cell_.push_back(first_of_cell_.back() + cell.faces);
  }
  std::vector<std::uint32_t> next(first_of_cell_.begin(), first_of_cell_.end() - 1);
  order_.resize(faces);
  for (std::uint32_t face = 0; face < faces; ++face) order_[next[cells.cell_of_face[face]]++] = face;
}

std::vector<FaceRun> CellRuns::in_view(const Camera& camera) const {
  const ViewPyramid pyramid = view_pyramid(camera);
  std::vector<FaceRun> runs;
  for (std::size_t cell = 0; cell < spheres_.size(); ++cell) {
    const glm::dvec3 center = camera.cam_from_world(spheres_[cell].center);
    if (outside(pyramid, center, spheres_[cell].radius)) continue;
    const std::uint32_t first = first_of_cell_[cell];
    const std::uint32_t count = first_of_cell_[cell + 1] - first;
    if (!runs.empty() && runs.back().first + runs.back().count == first) {
      runs.back().count += count;
    } else {
      runs.push_back({first, count});
    }
  }
  return runs;
}

}  // namespace lumatlas
