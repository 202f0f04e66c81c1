// SPDX-License-Identifier: GPL-3.0-or-later
// A scene's depth images, read for fusion.
#pragma once

#include <vector>

#include "tools/meshing/depth/depth_fusion.h"
#include "tools/scene/scene.h"

namespace lumatlas {

// Undistorted to a pinhole camera at the file's own size: it shows what its lens does, however many pixels it has. No
// depth is mixed of two. A pixel counts by the cosine of the angle that it sees the surface at, as its neighbours tell;
// those without a neighbour, beyond 84 degrees, and between the near and the far side of an edge count for nothing.
// Throws InputError naming a file that is missing, damaged, not of 16 bits, or of another shape than its lens.
[[nodiscard]] DepthImage read_depth(const SceneDepth& depth);

// The same depths, of which only those of no confidence are left out, without cosines and slopes.
[[nodiscard]] DepthImage read_flat_depth(const SceneDepth& depth);

// What read_depth() makes of depths without a lens's distortion, z in the camera frame by rows, 0: not measured. There
// must be as many as the camera has pixels; this is not checked.
[[nodiscard]] DepthImage slanted_depth(const Camera& camera, std::vector<float> depth);

// Returns how many pixels of its file are above 0, whether they can be used or not. Throws InputError.
[[nodiscard]] std::size_t pixels_above_zero(const SceneDepth& depth);

}  // namespace lumatlas
