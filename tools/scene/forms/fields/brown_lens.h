// SPDX-License-Identifier: GPL-3.0-or-later
// Lenses as calibration programs state them: by Brown's coefficients.
#pragma once

#include <cstdint>

#include "tools/scene/lenses/camera_model.h"

namespace lumatlas {

// A lens by Brown's coefficients with OpenCV's p1 and p2. k4 stands before r^8, as k3 stands before r^6.
struct BrownLens {
  std::uint32_t width = 0, height = 0;    // pixels
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixels, (0, 0) is the corner of the picture
  double k1 = 0, k2 = 0, k3 = 0, k4 = 0;  // radial
  double p1 = 0, p2 = 0;                  // tangential
  double p3 = 0, p4 = 0;                  // the tangential terms grow with 1 + p3 r^2 + p4 r^4
  double skew = 0;                        // pixels that x grows by for each unit of y in the plane z = 1
  bool fisheye = false;                   // the coefficients are of the angle to the axis instead of its tangent
};
// The simplest model that has all of the coefficients. Throws std::invalid_argument as check() does.
[[nodiscard]] CameraModel lens_of(const BrownLens& brown);

}  // namespace lumatlas
