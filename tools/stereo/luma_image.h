// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs as stereo sees them: brightness alone, small, in several sizes.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "atlas/images/photograph.h"
#include "mesh/camera/camera.h"

namespace lumatlas {

// sRGB luma, 0 to 255, of an undistorted photograph.
struct LumaImage {
  Camera camera;
  // A pixel's luma and those of the pixels to the right, below, and below to the right, from the lowest byte up: what
  // is read between four pixels lies in one place. The last column and row are repeated.
  std::vector<std::uint32_t> quads;
  std::vector<std::uint8_t> valid;  // see Photograph::valid

  [[nodiscard]] std::uint8_t luma(std::size_t pixel) const { return static_cast<std::uint8_t>(quads[pixel] & 0xFFU); }
  [[nodiscard]] bool is_valid(std::size_t pixel) const { return valid.empty() || valid[pixel] == 255; }
};

using LumaPyramid = std::vector<LumaImage>;  // the finest first, each half as wide and high as the one before

// Returns the levels of a photograph. The longer side of the first level has at most `longest` pixels, that of the last
// one at most `shortest`; nothing is enlarged. `photograph` has the camera's size. Throws std::invalid_argument if it
// does not, or if `shortest` is 0 or above `longest`.
[[nodiscard]] LumaPyramid luma_pyramid(const Photograph& photograph, const Camera& camera, std::uint32_t longest,
                                       std::uint32_t shortest);

}  // namespace lumatlas
