// SPDX-License-Identifier: GPL-3.0-or-later
// The error of the lens that a camera was given: the difference between the picture that the given lens makes and the
// one that a pinhole camera would make.
#pragma once

#include <glm/vec2.hpp>

#include "mesh/camera/camera.h"

namespace lumatlas {

// In the original photograph, a point (x, y) of the plane z = 1 in the camera frame lies at the pixel where the camera
// would see
//
//   focal * ((x, y) * (1 + k1 r^2 + k2 r^4) + (2 p1 xy + p2 (r^2 + 2 x^2), 2 p2 xy + p1 (r^2 + 2 y^2)))
//
// with r^2 = x^2 + y^2, moved by `principal` image widths. The terms are those of COLMAP's OPENCV model.
struct LensCorrection {
  double focal = 1;           // factor, > 0
  glm::dvec2 principal{0.0};  // image widths
  double k1 = 0, k2 = 0;      // radial
  double p1 = 0, p2 = 0;      // tangential

  friend bool operator==(const LensCorrection&, const LensCorrection&) = default;
};

// Throws std::invalid_argument naming the field, its value and the rule: `focal` finite and positive, all else finite.
void check(const LensCorrection& correction);

// Returns the pixel of the original photograph that shows the ideal pinhole pixel `image`; both in pixels of the
// camera.
[[nodiscard]] glm::dvec2 uncorrected(const LensCorrection& correction, const Camera& camera, const glm::dvec2& image);

// Returns whether two cameras have the same size, focal lengths and principal point, within 1e-9 of the width. They are
// then taken to share a lens.
[[nodiscard]] bool share_a_lens(const Camera& a, const Camera& b);

// Returns the largest distance by which the correction moves a corner of the camera's picture, pixels.
[[nodiscard]] double corner_move_px(const LensCorrection& correction, const Camera& camera);

// Returns the correction that does what `first` and then `second` do, to first order: products of two distortions are
// left out.
[[nodiscard]] LensCorrection combined(const LensCorrection& first, const LensCorrection& second);

}  // namespace lumatlas
