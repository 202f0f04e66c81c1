// SPDX-License-Identifier: GPL-3.0-or-later
// Shared by all comparisons of photographs with colours of the surface: how much a difference counts, and how a camera
// is moved. See alignment.h.
#pragma once

#include <glm/vec3.hpp>

#include "mesh/camera/camera.h"

namespace lumatlas {

inline constexpr double kTukeyCutoff = 4.685;  // in standard deviations: 95 % efficient on Gaussian noise
inline constexpr double kDeviationOfMedian =
    1.4826;                                     // standard deviation over median absolute deviation of normal noise
inline constexpr double kSmallestNoise = 0.01;  // sRGB; photographs are 8 bit and compressed

// d sRGB / d linear, bounded where the curve is steep and noise rules.
[[nodiscard]] double srgb_slope(double linear);

// Tukey's biweight as the square of a smooth function, which is what least squares wants: value^2 / 2 = rho, value ~ r
// near 0. `r` is in standard deviations.
struct Robust {
  double value, derivative;
};
[[nodiscard]] Robust tukey(double r);

// To the last bit.
[[nodiscard]] bool same_pose(const Camera& a, const Camera& b);

// The camera frame is turned by `turn` (a rotation vector), then moved by `shift`, scene units.
[[nodiscard]] Camera moved(Camera camera, const glm::dvec3& turn, const glm::dvec3& shift);

// The motion from `from` to `to`, for moved().
struct CameraMotion {
  glm::dvec3 turn{0.0};
  glm::dvec3 shift{0.0};
};
[[nodiscard]] CameraMotion motion_between(const Camera& from, const Camera& to);

}  // namespace lumatlas
