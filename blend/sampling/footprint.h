// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: the sampling kernel widens in a photograph where the surface is not exact.
//
// If the true point is d nearer or farther on the picture's ray than the surface, the photograph shows it displaced by
// about
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

// Shared with the shader.
inline constexpr double kBlurOfShift = 6;  // growth of w^2 per square pixel of shift
inline constexpr double kMostShift = 1e3;  // pixels; larger shifts are cut to it, so that their squares stay finite
inline constexpr double kSharpShift = 1;   // pixels; shifts up to it blur nothing

// Returns 6 (S^2 - 1), or 0 where S is at most 1. `deviation` is D, scene units. `to_novel` and `to_stored` point from
// the point to the two cameras. `focal_length` (pixels) and `depth` (scene units) are the photograph's.
[[nodiscard]] inline double blur_of(double deviation, const glm::dvec3& to_novel, const glm::dvec3& to_stored,
                                    double focal_length, double depth) {
  if (!(deviation > 0)) return 0;
  const double sine = glm::length(glm::cross(glm::normalize(to_novel), glm::normalize(to_stored)));
  const double shift = std::min(deviation * sine * focal_length / depth, kMostShift);
  return kBlurOfShift * std::max(0.0, shift * shift - kSharpShift * kSharpShift);
}

// Returns the width of the sampling kernel, in pixels of the photograph. `footprint`: its width for an exact surface.
[[nodiscard]] inline double blurred_footprint(double footprint, double blur) {
  if (!(blur > 0)) return footprint;
  const double wide = std::max(footprint, 1.0);
  return std::sqrt(wide * wide + blur);
}

}  // namespace lumatlas
