// SPDX-License-Identifier: GPL-3.0-or-later
// Cells of a mesh that changes while views of it are stored already: surface that stays keeps its cell, so that the
// cell's data can be kept. Erat et al. 2019, section 5, ask for it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/base/id.h"
#include "mesh/cells/cells.h"
#include "mesh/mesh.h"

namespace lumatlas {

// Returns for each face of `mesh` the face of `before` at the same place, or FaceId::none: the three corners of both
// have the same coordinates, to the bit, and the same turn. The order of faces and vertices, and which corner comes
// first, do not matter. Faces at one place are matched one to one, in their order. Coordinates may be anything, also
// not finite. Throws std::invalid_argument for a face that refers to no vertex.
[[nodiscard]] std::vector<FaceId> match_faces(const Mesh& before, const Mesh& mesh);

struct CellGrowth {
  Cells cells;
  std::vector<CellId> previous_cell;  // for each cell its number before, ascending; CellId::none: it is new
  std::vector<std::uint8_t> changed;  // one per cell: 1 if it is new, gained or lost faces, or has one that moved
};

// Returns the cells of `mesh`, which `mesh_before` with the cells `before` has become. `previous_face` says for each
// face which one it was, wherever its corners were then, or FaceId::none for one that is new: see match_faces().
//
// Clusters: a face stays in the cell that it was in. New faces form cells among themselves, as make_cells() forms them;
// those much smaller than the target join a neighbour, old or new, that they fit, and an old cell as small takes one of
// them in. Old cells never merge, so that a surface that comes in many small parts has more cells than one that is
// there at once. A cell may fall apart when faces are taken out of its middle.
//
// Grid: a cell is the faces in its cube, new or old, as make_cells() has them.
//
// With both, a cell without faces is dropped, and a cell that is not `changed` keeps its statistics to the bit. Old
// cells come first, in their order; new ones follow by their first face. Deterministic: the same bytes for any number
// of threads.
//
// The new faces should be no larger than a cell (split_large_faces with before.size). `options` are those that the
// cells before were made with: a size other than before.size is refused, unless it is 0. Without cells before, the
// result is that of make_cells(). Throws std::invalid_argument for bad options, if one of the meshes breaks a rule of
// mesh.h, and for a changed mesh without faces. Also if `previous_face` has not one entry per face, names a face that
// was not there or names one twice; if `before` is not of `mesh_before`; and if the partition is a grid and the cells
// before are not its cubes.
[[nodiscard]] CellGrowth grow_cells(const Mesh& mesh_before, const Cells& before, const Mesh& mesh,
                                    std::span<const FaceId> previous_face, const CellOptions& options);

}  // namespace lumatlas
