// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: which faces of a soup are faces of the version before it.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "mesh/base/id.h"

namespace lumatlas {

// Two versions of a soup, and what its maker says of them.
struct SoupVersions {
  std::span<const glm::uvec3> faces_before, faces;
  std::span<const VertexId> previous_position;  // one per position; empty: all positions are new
  std::span<const FaceId> previous_face;        // as GrownSoup has it
};

struct KeptFaces {
  std::vector<FaceId> before;  // for each face which one it was; FaceId::none: it is new
  // By face, the corner that its first corner was before. Empty: all faces begin with the corner that they began with.
  std::vector<std::uint8_t> first_corner;
  bool in_order = true;  // faces that stay come in the order that they had
};

// Takes the faces that `previous_face` names, and finds the others by the positions of their corners. Faces between the
// same three positions in the same turn are matched one to one, in their order. Throws std::invalid_argument unless
// `previous_face` is empty or has one entry per face, ascending without those that are none, each a face whose corners
// were these positions in this order.
[[nodiscard]] KeptFaces kept_faces(const SoupVersions& versions);

}  // namespace lumatlas
