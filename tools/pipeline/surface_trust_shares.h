// SPDX-License-Identifier: GPL-3.0-or-later
// How much of what photographs see is surface that can be trusted.
#pragma once

#include "atlas/snapshot.h"
#include "mesh/visibility.h"
#include "planner/surface_deviation.h"

namespace lumatlas {

// Shares of the pixels of the stored photographs that see the near surface, [0, 1]: of surface whose deviation shifts
// it by at most so many of their pixels when it is shown from kTrustAngle degrees beside them (shift_px()).
struct TrustShares {
  double within_1_px = 0;
  double within_2_px = 0;
  double within_4_px = 0;
  double measured = 0;  // of surface whose deviation photographs tell; that of the rest is its neighbours'
};

// `visibility` is that of the snapshot's surface. All shares are 0 where no photograph sees it.
[[nodiscard]] TrustShares trust_shares(const Snapshot& snapshot, const SurfaceDeviation& deviation,
                                       const Visibility& visibility);

}  // namespace lumatlas
