// SPDX-License-Identifier: GPL-3.0-or-later
// Pixels as means of several samples, as a photograph's are over the pixel's area, in linear light. Where samples have
// the middle's colour, this is cut off at white before.
//
//   Samples are at the middles of N x N equal parts of a pixel; each covers 1 / N of its width.
//   Whether a pixel shows the surface, and its PixelState, are those of its middle, whatever N is.
//   Its colour is the mean over the samples that see the surface, so that black from beside the mesh never comes into
//   it; where none does, the colour of the middle.
//
// With Antialias::silhouettes that is so where one sample is likely wrong; other pixels keep the colour of their
// middle, which covers all of their width. With z and z' the depths at the middles of a pixel and of one of its eight
// neighbours in the picture, and f the focal length fx in pixels, a pixel is at a silhouette if its middle sees the
// surface and
//
//   the middle of a neighbour sees none, or
//   f |z / z' + z / z'' - 2| > kSilhouetteBend for two neighbours opposite each other.
//
// On a plane 1 / z is linear in the image, so that the left side is 0 there from all directions. Elsewhere it is how
// far the surface bends away from the plane of the neighbours, in widths of a pixel at its depth. Steps in depth bend
// it that much; creases only if one side is nearly edge-on (a right angle seen from its middle gives 2). A surface
// narrower than a pixel that no middle sees goes unnoticed.
//
// There a colour counts as often as samples see its surface, and no sample is shaded that another one stands for: the
// samples of the middle's surface have the middle's colour, as it is shown, and those of any other surface the colour
// of the first of them, from the top left. With Antialias::all each sample has its own. A sample with depth z' is of
// the surface at z if
//
//   f |z / z' - 1| < kSameSurface.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "blend/blend_options.h"
#include "mesh/camera/camera.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// One for each of the `across` x `across` samples: the same size and pose, but the middles of its pixels see what those
// samples of `camera` see. For 1, the camera itself. Throws std::invalid_argument unless the camera passes check() and
// `across` is in [1, kMostSupersampling].
[[nodiscard]] std::vector<Camera> sample_cameras(const Camera& camera, std::uint32_t across);

// Returns 1 for each pixel at a silhouette, else 0. Throws std::invalid_argument unless `visible` has a depth and a
// face for each pixel of the camera's image.
[[nodiscard]] std::vector<std::uint8_t> silhouettes(const Camera& camera, const VisibilityBuffer& visible);

// For each pixel, how often its middle's colour counts, and the colour of each of its samples.
struct SampleCounts {
  std::vector<std::uint8_t> middle;
  std::vector<std::vector<std::uint8_t>> samples;  // in the order of sample_cameras()
};

// `visible`, and one of `samples` for each of sample_cameras(): what the camera and they see. Pixels that are not
// `sampled` have 0 everywhere. All must be of the camera's size.
[[nodiscard]] SampleCounts sample_counts(const Camera& camera, const VisibilityBuffer& visible,
                                         std::span<const VisibilityBuffer> samples,
                                         const std::vector<std::uint8_t>& sampled, BlendOptions::Antialias antialias);

// The same options for one sample a pixel, at its middle.
[[nodiscard]] BlendOptions at_middle(const BlendOptions& options);

}  // namespace lumatlas
