// SPDX-License-Identifier: GPL-3.0-or-later
// The black rim that an undistortion by another program leaves in a photograph.
#pragma once

#include <vector>

#include "atlas/images/photograph.h"

namespace lumatlas {

// True for each pixel of the rim: black (at most 12 of 255 in every channel, which is what JPEG makes of 0), connected
// to the photograph's border through such pixels, and within a tenth of the shorter side of that border; and the two
// pixels beside those, which the resampling and JPEG have darkened. A photograph without a rim gives all false.
[[nodiscard]] std::vector<bool> black_rim(const Photograph& photograph);

}  // namespace lumatlas
