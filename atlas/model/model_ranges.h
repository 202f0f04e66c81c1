// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: the ranges of numbers in a model file that are useless outside them, although every other check
// would let them pass. The writer keeps to them and the reader refuses the rest, so that every model that is written
// can be read.
#pragma once

#include "mesh/camera/camera.h"
#include "mesh/mesh.h"

namespace lumatlas {

// Each coordinate of an offset is within this of 0: beyond it, positions do not fit into floats.
inline constexpr double kMostOffset = 3.4e38;

// Each component of a camera's translation is within this of 0, scene units. Scenes have cameras within 1e12 of 0, from
// which the offset is subtracted.
inline constexpr double kMostTranslation = 1e13;

// Focal lengths, relative to the image's longer side: from side / 1e6, nearly 180 degrees, to 1e9 * side, nearly none.
inline constexpr double kMostSidePerFocalLength = 1e6;
inline constexpr double kMostFocalShare = 1e9;

// Each coordinate of a principal point is within this share of the image's longer side of 0.
inline constexpr double kMostPrincipalShare = 1e9;

// The largest target diameter of a cell, scene units: the diagonal of the mesh's box, in which every cell lies.
[[nodiscard]] double most_cell_size(const Mesh& mesh);

// Throws std::invalid_argument naming the field, its value and the range. The camera passes its own check().
void check_model_ranges(const Camera& camera);

}  // namespace lumatlas
