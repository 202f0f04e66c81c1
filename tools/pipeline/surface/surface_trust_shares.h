// SPDX-License-Identifier: GPL-3.0-or-later
// Measures which share of the surface in the photographs is near its true place.
#pragma once

#include "atlas/snapshot.h"
#include "mesh/visibility/visibility.h"
#include "planner/refinement/surface_deviation.h"

namespace lumatlas {

// Shares, [0, 1], of the stored photographs' pixels that see the near surface.
struct TrustShares {
  double within_1_px = 0;  // the surface's error shifts the pixel by at most 1 pixel, see shift_px()
  double within_2_px = 0;  // share that is off by at most 2 pixels
  double within_4_px = 0;  // share that is off by at most 4 pixels
  double measured = 0;     // the pixel's cell was measured, see SurfaceDeviation::measured
};

// Counts pixels of small images through the cameras of the stored views. Returns zeros where no photograph sees the
// near surface. `visibility` is that of the snapshot's surface.
[[nodiscard]] TrustShares trust_shares(const Snapshot& snapshot, const SurfaceDeviation& deviation,
                                       const Visibility& visibility);

}  // namespace lumatlas
