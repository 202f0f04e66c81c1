// SPDX-License-Identifier: GPL-3.0-or-later
// Packs the mesh of a model for a page: the renderer's own copy of it, by fade zones (zone_mesh.h), with positions on a
// grid finer than any photograph resolves, and in an order that packs well.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

#include "atlas/snapshot.h"
#include "blend/tables/zone_mesh.h"
#include "tools/viewer/packed_arrays.h"

namespace lumatlas {

// The grid of positions: origin + step * whole numbers.
struct PositionGrid {
  glm::dvec3 origin{0.0};
  double step = 1;  // scene units, > 0
};

// Steps of a 64th of what a pixel of a stored photograph covers at its view's median depth, the least over the
// views, but no more than a hundredth of a cell, and no finer than 2^24 steps across the mesh, which a float resolves.
[[nodiscard]] PositionGrid position_grid(const Snapshot& snapshot);

struct PackedMesh {
  PackedArrays arrays;  // corners, positions, colors, shares, zones: as in ZoneMesh
  PositionGrid grid;
  std::vector<std::size_t> corner_counts;  // corners of the faces for each of kCellsOfShader
  std::vector<std::uint32_t> vertices;     // the vertices of the ZoneMesh in their order here
};

// Changes the order of the mesh's vertices, and that of the faces within each of its groups.
[[nodiscard]] PackedMesh packed_mesh(const ZoneMesh& mesh, const PositionGrid& grid);

// The mesh with its vertex colours alone, in about `faces` faces, so that it comes at once. More faces stay where fewer
// would close its holes. Empty where the mesh has at most twice as many.
[[nodiscard]] ZoneMesh coarse_mesh(const Snapshot& snapshot, std::size_t faces);

}  // namespace lumatlas
