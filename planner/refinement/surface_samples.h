// SPDX-License-Identifier: GPL-3.0-or-later
// The surface points at which a photograph is compared with others (Erat et al. 2019, section 3.3: the X_j).
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "mesh/visibility/visibility.h"
#include "planner/refinement/pyramid.h"

namespace lumatlas {

struct SurfaceSample {
  glm::dvec3 position;  // in the world
  glm::dvec2 image;     // in the photograph, pixels
  FaceId face;
};

// Colours that carry no information: sRGB values of 8 bit below or above these are too dark, or clipped.
inline constexpr std::uint8_t kDarkestSample = 8;
inline constexpr std::uint8_t kBrightestSample = 247;
[[nodiscard]] bool is_exposed(const std::uint8_t* rgb);

// The longer side, at most `most_px`, of the image in which to choose points of a photograph. Its pixels' centres fall
// on all places within the photograph's pixels: were they all at centres, say, then interpolation would leave the
// photograph's noise as it is there and halve it half a pixel further, and alignment would go and look for that.
// Both are at least 1 (std::invalid_argument).
[[nodiscard]] std::uint32_t sampling_px(std::uint32_t photograph_px, std::uint32_t most_px);

// About `count` points, spread evenly over the picture: of each block, the one of largest image gradient, for the pose,
// and the one nearest to its middle, for the exposure. None at depth edges, outside the lens's image, too dark or
// clipped. `visible` is what the camera sees at any resolution; points are at its pixels' centres. Throws
// std::invalid_argument if the photograph's size is not the camera's, or if `visible` is empty or not filled.
[[nodiscard]] std::vector<SurfaceSample> choose_surface_samples(const Camera& camera, const Pyramid& photograph,
                                                                const VisibilityBuffer& visible, std::size_t count);

}  // namespace lumatlas
