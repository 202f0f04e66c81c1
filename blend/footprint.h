// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: how much wider a pixel of the picture is in a photograph because the surface is not exact.
//
// A photograph shows a point elsewhere that is d nearer or farther on the picture's ray than the surface: by about
//
//   s = d sin(a) f / z     pixels, with a the angle between the two rays, f the photograph's focal length in pixels
//                          and z the point's depth there,
//
// along the epipolar line. So a picture from where the photograph was taken is as sharp as that, whatever the surface
// is; from elsewhere the colour is the mean over where the point may be. With d normal of standard deviation D, s has
// the variance S^2 along the line and 0 across it. What is sampled is a round kernel with the same variance in all,
// S^2 / 2 along each axis; that of a mean over w pixels is w^2 / 12. So w^2 would grow by 6 S^2. Up to a shift of one
// pixel nothing is blurred, because a sharp picture that is off by less looks better:
//
//   w^2 becomes max(1, w^2) + 6 (S^2 - 1) where S is above 1.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace lumatlas {

inline constexpr double kBlurOfShift = 6;  // of S^2; shared with the shader, as is the next one
inline constexpr double kMostShift = 1e3;  // pixels: more blurs no further
inline constexpr double kSharpShift = 1;   // pixels

// Returns 6 (S^2 - 1), or 0. `deviation`: D, scene units. The directions point from the point to
// the two cameras, of any length. `focal_length` and `depth` are the photograph's.
[[nodiscard]] inline double blur_of(double deviation, const glm::dvec3& to_novel, const glm::dvec3& to_stored,
                                    double focal_length, double depth) {
  if (!(deviation > 0)) return 0;
  const double sine = glm::length(glm::cross(glm::normalize(to_novel), glm::normalize(to_stored)));
  const double shift = std::min(deviation * sine * focal_length / depth, kMostShift);
  return kBlurOfShift * std::max(0.0, shift * shift - kSharpShift * kSharpShift);
}

// The width that is sampled of a photograph, pixels.
[[nodiscard]] inline double blurred_footprint(double footprint, double blur) {
  if (!(blur > 0)) return footprint;
  const double wide = std::max(footprint, 1.0);
  return std::sqrt(wide * wide + blur);
}

}  // namespace lumatlas
