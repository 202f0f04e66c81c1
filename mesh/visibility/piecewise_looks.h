// SPDX-License-Identifier: GPL-3.0-or-later
// Finds what cameras see of a mesh that is too large for memory and comes in pieces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "mesh/camera/camera.h"
#include "mesh/cancel_check.h"
#include "mesh/mesh.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

struct MeshPiece {
  Bounds box;                  // around its vertices
  std::size_t faces = 0;       // at least 1
  std::function<Mesh()> load;  // returns the piece; may be called several times
};

// Calls use() with the number of each camera, in their order, and what it sees, by casting rays (RayVisibility). Faces
// are numbered over all pieces in their order. A camera sees what one mesh of all pieces would show, except that where
// two faces of different pieces are at the same depth, that of the earlier piece is seen. Holds one piece, and the
// pictures of as many cameras as take at most `picture_bytes`, or of one: for these each piece is loaded once that one
// of them may show, so that cameras which follow each other should be near each other. The same for any number of
// threads. `cancel_check` is called between pieces. Throws std::invalid_argument for a bad camera.
void look_at_pieces(const std::vector<MeshPiece>& pieces, std::span<const Camera> cameras, std::uint64_t picture_bytes,
                    const std::function<void(std::size_t camera, const VisibilityBuffer& seen)>& use,
                    const CancelCheck& cancel_check = {});

}  // namespace lumatlas
