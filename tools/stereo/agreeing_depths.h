// SPDX-License-Identifier: GPL-3.0-or-later
// Depths of a photograph that other photographs confirm.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/camera/camera.h"
#include "tools/stereo/patch_match.h"

namespace lumatlas {

// One value a pixel, row by row.
struct StereoDepth {
  Camera camera;
  std::vector<float> depth;             // z in the camera frame at the pixel's middle, scene units; 0: not known
  std::vector<float> deviation;         // standard deviation of depth, scene units
  std::vector<std::uint32_t> agreeing;  // bit i is set if photograph i of `others` confirms the depth
};

struct AgreementOptions {
  float most_cost = 0.5F;         // largest matching cost of a plane, [0, 2]
  float most_way_px = 1.5F;       // largest reprojection error there and back, pixels
  float most_difference = 0.05F;  // largest relative difference of the two depths
  std::size_t least_views = 1;    // photographs that must confirm a depth; with fewer others, all of these
};

// A plane map with its camera, of the map's size.
struct PosedPlanes {
  Camera camera;
  const PlaneMap* planes;
};

// Returns the depths of `reference` that the `others`, at most 32, confirm. A photograph confirms a depth if its own
// plane at that surface point leads back to the pixel, by options.most_way_px and most_difference. The result is the
// mean of the confirming depths and the pixel's own (geometric consistency, Schoenberger et al. 2016, section 4.4).
[[nodiscard]] StereoDepth agreeing_depths(const PosedPlanes& reference, std::span<const PosedPlanes> others,
                                          const AgreementOptions& options);

}  // namespace lumatlas
