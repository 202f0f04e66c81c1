// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the part of a camera's image that may show what lies in a box.
#pragma once

#include <cstdint>

#include "mesh/camera/camera.h"
#include "mesh/mesh.h"

namespace lumatlas {

// The pixels in which a camera shows a box, or would without what stands before it.
struct ShownBox {
  std::uint32_t left = 0, top = 0, right = 0, bottom = 0;  // the last two are beyond it
  double near = 0, far = 0;                                // least and largest depth of the box, z in the camera frame

  [[nodiscard]] bool empty() const { return left >= right || top >= bottom; }
};

// Returns no pixel for a box behind the camera, and the whole image for one that reaches around it.
[[nodiscard]] ShownBox shown_box(const Camera& camera, const Bounds& box);

}  // namespace lumatlas
