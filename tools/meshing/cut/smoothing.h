// SPDX-License-Identifier: GPL-3.0-or-later
// A surface through noisy points made as smooth as their noise allows.
#pragma once

#include <span>

#include "mesh/mesh.h"

namespace lumatlas {

// Moves each vertex towards the mean of its edge neighbours, in five rounds. A vertex stays within its deviation of
// where it was, and border vertices do not move. `deviations`: one per vertex, scene units, >= 0. Throws
// std::invalid_argument for another number of deviations.
void smooth(TriangleSoup& surface, std::span<const float> deviations);

}  // namespace lumatlas
