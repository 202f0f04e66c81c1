// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/surface.h"

#include <stdexcept>
#include <string>

namespace lumatlas {

namespace {

[[noreturn]] void refuse_surface(const std::string& why) {
  throw std::invalid_argument("surface: " + why);
}

void check_cells(const Cells& cells, std::size_t faces) {
  if (cells.cell_of_face.size() != faces) {
    refuse_surface("cells.cell_of_face has " + std::to_string(cells.cell_of_face.size()) +
                   " entries, must have one per face, " + std::to_string(faces));
  }
  for (std::size_t face = 0; face < faces; ++face) {
    if (cells.cell_of_face[face] < cells.cells.size()) continue;
    refuse_surface("cells.cell_of_face[" + std::to_string(face) + "] is " + std::to_string(cells.cell_of_face[face]) +
                   ", must be below the number of cells, " + std::to_string(cells.cells.size()));
  }
}

}  // namespace

void check(const Surface& surface) {
  const Mesh& mesh = surface.mesh;
  if (!mesh.colors.empty() && mesh.colors.size() != mesh.positions.size()) {
    refuse_surface("mesh.colors has " + std::to_string(mesh.colors.size()) + " entries, must have one per vertex, " +
                   std::to_string(mesh.positions.size()) + ", or none");
  }
  check_faces(mesh);
  check_cells(surface.cells, mesh.faces.size());
}

}  // namespace lumatlas
