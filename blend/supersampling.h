// SPDX-License-Identifier: GPL-3.0-or-later
// Pixels as means of several samples, as a photograph's are over the pixel's area, in linear light before anything is
// cut off at white:
//
//   Samples are at the middles of N x N equal parts of a pixel; each covers 1 / N of its width.
//   Whether a pixel shows the surface, and its PixelState, are those of its middle, whatever N is.
//   Its colour is the mean over the samples that see the surface, so that black from beside the mesh never comes into
//   it; where none does, the colour of the middle.
#pragma once

#include <cstdint>
#include <vector>

#include "blend/blend_options.h"
#include "mesh/camera.h"

namespace lumatlas {

// One for each of the `across` x `across` samples: the same size and pose, but the middles of its pixels see what those
// samples of `camera` see. For 1, the camera itself.
[[nodiscard]] std::vector<Camera> sample_cameras(const Camera& camera, std::uint32_t across);

// Of the one sample at the middle of a pixel.
[[nodiscard]] BlendOptions at_middle(const BlendOptions& options);

}  // namespace lumatlas
