// SPDX-License-Identifier: GPL-3.0-or-later
// Measures the depths of what stored views show.
#pragma once

#include <vector>

#include "atlas/atlas.h"

namespace lumatlas {

// Depth z of about a hundredth of the pixels of each stored view that show the mesh, scene units; in no order.
[[nodiscard]] std::vector<double> sampled_depths(const Snapshot& snapshot);

}  // namespace lumatlas
