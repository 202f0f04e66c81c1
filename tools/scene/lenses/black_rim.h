// SPDX-License-Identifier: GPL-3.0-or-later
// The black rim that an undistortion by another program leaves in a photograph.
#pragma once

#include <vector>

#include "atlas/images/photograph.h"

namespace lumatlas {

// Returns true for each pixel of the rim. A rim pixel is black (at most 12 of 255 in every channel, as JPEG codes 0),
// connected to the photograph's border through such pixels, and within a tenth of the shorter side of that border. The
// two pixels beside these, which resampling and JPEG have darkened, belong to the rim too. A photograph without a rim
// gives all false.
[[nodiscard]] std::vector<bool> black_rim(const Photograph& photograph);

}  // namespace lumatlas
