// SPDX-License-Identifier: GPL-3.0-or-later
// A surface through noisy points made as smooth as their noise allows.
#pragma once

#include <span>

#include "mesh/mesh.h"

namespace lumatlas {

// Each vertex moves towards the middle of those that it shares an edge with, some times over, and never farther from
// where it was than `deviations` says of it (one a vertex, scene units, >= 0). Vertices at a border of the surface
// stay. Throws std::invalid_argument if there is not a deviation for each vertex.
void smooth(TriangleSoup& surface, std::span<const float> deviations);

}  // namespace lumatlas
