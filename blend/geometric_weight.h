// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: how like the novel view a stored one is, seen from a point, and how its weight falls near the
// border of its photograph.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "blend/blend_options.h"

namespace lumatlas {

// In the band along a photograph's border, 1 - w of its view grows to (1 - w + kFramePenalty (1 - frame)) / frame;
// `frame` falls to 0 at the border. Above 0, so that a photograph fades in a picture from its own place too: where
// `frame` is a half, it weighs there as a photograph from 9 degrees aside. Shared with the shader.
inline constexpr double kFramePenalty = 0.01;

// The least share of `frame` times its weight that a view keeps in that band, so that it shows where no other view is
// valid. In most of the band above that of contradicted pixels, 1 / 255; far below other views. Shared with the shader.
inline constexpr double kLeastInFrame = 0.05;

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

// The weight of a view where `frame` is the share that is left of its photograph: continuous in both, at most `weight`,
// equal to it where `frame` is 1, and 0 where `frame` is 0. The view first ranks as a worse one, so that the next best
// view follows it continuously; then it keeps kLeastInFrame * frame * weight.
[[nodiscard]] double weight_in_frame(double weight, double frame);

}  // namespace lumatlas
