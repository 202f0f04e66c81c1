// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: where a face is, to the bit, whichever of its corners comes first.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "mesh/base/id.h"
#include "mesh/mesh.h"

namespace lumatlas {

// The bits of x, y and z of the three corners, which are in an order that all whole numbers have: unlike floats, also
// where one is not a number.
using FaceCorners = std::array<std::uint32_t, 9>;

// The corners of the face in that one of its three turns which comes first in order.
[[nodiscard]] inline FaceCorners face_corners(const Mesh& mesh, FaceId face) {
  FaceCorners corners{};
  for (int corner = 0; corner < 3; ++corner) {
    const glm::vec3& position = mesh.positions[mesh.faces[face][corner]];
    for (int axis = 0; axis < 3; ++axis) {
      corners[3 * static_cast<std::size_t>(corner) + static_cast<std::size_t>(axis)] =
          std::bit_cast<std::uint32_t>(position[axis] + 0.0f);  // -0 becomes 0
    }
  }
  FaceCorners least = corners;
  for (int turn = 1; turn < 3; ++turn) {
    std::rotate(corners.begin(), corners.begin() + 3, corners.end());
    least = std::min(least, corners);
  }
  return least;
}

}  // namespace lumatlas
