// SPDX-License-Identifier: GPL-3.0-or-later
// Visibility of a mesh that is too large for memory: it comes in pieces, of which those that were needed last are kept.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <vector>

#include "mesh/mesh.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

struct MeshPiece {
  Bounds box;                  // around its vertices
  std::size_t faces = 0;       // at least 1
  std::function<Mesh()> load;  // returns the piece; called from any thread, possibly several times
};

// Casts rays into the pieces that a camera may show, the nearest first, and leaves out those behind what it has seen.
// Faces are numbered over all pieces in their order. Sees what one mesh of all pieces would show, except that
// where two faces of different pieces are at the same depth, either may be seen. Looks from neighbouring places, one
// after the other, load a piece once.
class PiecewiseVisibility final : public Visibility {
 public:
  // `most_faces`: of the pieces that are kept. Each thread that looks needs one piece more for a moment.
  PiecewiseVisibility(std::vector<MeshPiece> pieces, std::size_t most_faces);

  using Visibility::trace;
  void trace(const Camera& camera, VisibilityBuffer& buffer) const override;

  [[nodiscard]] std::size_t loads() const;  // how often a piece was loaded until now

 private:
  struct Kept {
    std::size_t piece;
    std::shared_ptr<const Visibility> visibility;
  };
  [[nodiscard]] std::shared_ptr<const Visibility> visibility_of(std::size_t piece) const;

  std::vector<MeshPiece> pieces_;
  std::vector<std::size_t> first_face_;  // of each piece
  std::size_t most_faces_;
  mutable std::mutex mutex_;      // guards the rest
  mutable std::list<Kept> kept_;  // the one used last comes first
  mutable std::size_t kept_faces_ = 0, loads_ = 0;
};

}  // namespace lumatlas
