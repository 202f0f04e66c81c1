// SPDX-License-Identifier: GPL-3.0-or-later
// How well two ways to find the visible surface agree where silhouettes do not decide.
#pragma once

#include <cstddef>

#include "mesh/visibility/visibility.h"

namespace lumatlas {

struct VisibilityAgreement {
  std::size_t pixels = 0;      // of all images
  std::size_t smooth = 0;      // pixels that count: away from silhouettes
  std::size_t differ = 0;      // of those
  std::size_t other_face = 0;  // of those, whether they differ or not
  double worst_depth = 0;      // relative, of the smooth pixels with the same face
  [[nodiscard]] double share_smooth() const { return static_cast<double>(smooth) / static_cast<double>(pixels); }
  [[nodiscard]] double share_equal() const { return 1 - static_cast<double>(differ) / static_cast<double>(smooth); }
  [[nodiscard]] double share_same_face() const {
    return 1 - static_cast<double>(other_face) / static_cast<double>(smooth);
  }
};

// Adds a pair of images. A pixel is away from silhouettes if the 3x3 pixels around it in `expected` are all empty, or
// all surface whose depths are within 5 % of each other. It is equal if both are empty, or have the same face, or
// depths within 1e-4 of each other: where two faces meet, rounding decides which of them it is.
void compare(const VisibilityBuffer& expected, const VisibilityBuffer& actual, VisibilityAgreement& agreement);

}  // namespace lumatlas
