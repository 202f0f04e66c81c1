// SPDX-License-Identifier: GPL-3.0-or-later
// The depths of a photograph that others confirm.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/camera.h"
#include "tools/stereo/patch_match.h"

namespace lumatlas {

// One value a pixel, row by row.
struct StereoDepth {
  Camera camera;
  std::vector<float> depth;             // z in the camera frame at the pixel's middle, scene units; 0: not known
  std::vector<float> deviation;         // standard deviation of depth, scene units
  std::vector<std::uint32_t> agreeing;  // a bit for each of the others that confirms it, the lowest for the first
};

struct AgreementOptions {
  float most_cost = 0.5F;         // of a plane, [0, 2]
  float most_way_px = 1.5F;       // from a pixel to another photograph and back by that one's plane
  float most_difference = 0.05F;  // of the two depths, as a share
  std::size_t least_views = 1;    // that must agree; where fewer see a photograph at all, those
};

// A plane map with its camera, of the map's size.
struct PosedPlanes {
  Camera camera;
  const PlaneMap* planes;
};

// A pixel's depth counts where as many others as the options say come back to it. Depth is the mean of all that agree.
// At most 32 others.
[[nodiscard]] StereoDepth agreeing_depths(const PosedPlanes& reference, std::span<const PosedPlanes> others,
                                          const AgreementOptions& options);

}  // namespace lumatlas
