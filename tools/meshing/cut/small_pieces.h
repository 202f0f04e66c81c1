// SPDX-License-Identifier: GPL-3.0-or-later
// Pieces of a surface that hang together with nothing else.
#pragma once

#include <cstddef>

#include "mesh/mesh.h"

namespace lumatlas {

struct RemovedPieces {
  std::size_t pieces = 0, faces = 0;
};

// Takes away the faces of pieces that have fewer than `fewest_faces`. Faces that share a vertex are of one piece.
// Positions stay, also those that no face uses any more.
RemovedPieces remove_small_pieces(TriangleSoup& soup, std::size_t fewest_faces);

}  // namespace lumatlas
