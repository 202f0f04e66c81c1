// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: how like the novel view a stored one is, seen from a point, and how its weight falls where it
// ends.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "blend/blend_options.h"

namespace lumatlas {

// Where only the share `left` of a view is left, its 1 - w grows to (1 - w + kFadePenalty (1 - left)) / left. The
// penalty is above 0, so that a photograph fades in a picture from its own place too: where `left` is a half, it weighs
// there as a photograph from 9 degrees aside. Shared with the shader.
inline constexpr double kFadePenalty = 0.01;

// The least share of `left` times its weight that a view keeps, so that it shows where no other view is valid: far
// below other views. Shared with the shader.
inline constexpr double kLeastFaded = 0.05;

// Width of the band on the far sphere, as a share of the photograph's shorter side: the band is the whole photograph.
// All photographs see the far sphere from nearly the same direction, so the band decides between them: a point comes
// mostly from the photograph that has it nearest to the middle. What photographs disagree about, such as clouds, fades
// widely. Shared with the shader.
inline constexpr double kFarFrameFade = 0.5;

// lambda w_dir + (1 - lambda) w_pos of blend_options.h, in [0, 1]; 0 at the place of either camera.
[[nodiscard]] double geometric_weight(const glm::dvec3& world, const glm::dvec3& novel_center,
                                      const glm::dvec3& stored_center, const BlendOptions& options);

// Returns the factor of a view's weight for a point at a rim in that view (rim_pixels()), in [0, 1]. It is 1 if the two
// cameras see the point from directions within kRimNearDegrees of each other, and 0 beyond kRimFarDegrees or if the
// options leave rims out.
[[nodiscard]] double rim_share(const glm::dvec3& world, const glm::dvec3& novel_center, const glm::dvec3& stored_center,
                               const BlendOptions& options);

// The share that is left of a photograph of that size at a pixel of it, in [0, 1]: 0 at its border, 1 where the border
// is farther than the band, smooth between; 1 everywhere without a band. `fade`: the band's width, a share of the
// photograph's shorter side, options.frame_fade or kFarFrameFade.
[[nodiscard]] double frame_share(const glm::dvec2& image, const glm::dvec2& size, double fade);

// The weight of a view at a point where the share `left` of it is left, in [0, 1]: the product of its validity mask, of
// rim_share() and of frame_share(). Continuous in both, at most `weight`, equal to it where `left` is 1, and 0 where
// `left` is 0. The view first ranks as a worse one, so that the next best view follows it continuously; then it keeps
// kLeastFaded * left * weight.
[[nodiscard]] double faded_weight(double weight, double left);

}  // namespace lumatlas
