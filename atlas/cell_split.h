// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: a mesh whose vertices each belong to one cell, so that the cell is an attribute of the vertex.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "mesh/mesh.h"

namespace lumatlas {

struct CellSplit {
  std::vector<glm::uvec3> faces;              // in their order, with the numbers of split vertices
  std::vector<std::uint32_t> source;          // by split vertex: which vertex of the mesh it is
  std::vector<std::uint32_t> cell_of_vertex;  // by split vertex; 0 if no face has it
};

// The vertices of the mesh come first, each for the cell of the first face that has it; its copies for other cells
// follow. A mesh that is split already stays as it is. `cell_of_face` has one entry per face.
[[nodiscard]] CellSplit split_at_cells(const Mesh& mesh, std::span<const std::uint32_t> cell_of_face);

}  // namespace lumatlas
