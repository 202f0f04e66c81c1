// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: visibility with a ray for every second pixel of every second row, and for others only where the
// surface is not smooth.
#pragma once

#include <cstdint>
#include <span>

#include "mesh/base/pixel_rect.h"
#include "mesh/camera/camera.h"
#include "mesh/visibility/embree_scene.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// Pixels are traced in squares of that many a side, which depend on pixels of the two squares around at most.
inline constexpr std::uint32_t kRaySquareSide = 64;

// Implements Visibility::trace_sparsely(), and RayVisibility::trace_part() unless `wanted` is empty. The buffer and
// `wanted` have the size of the window, whose left and top are multiples of kRaySquareSide. The result is the same on
// any number of threads.
void trace_sparsely(const Camera& camera, const PixelRect& window, const TracedMesh& mesh,
                    std::span<const std::uint8_t> wanted, VisibilityBuffer& buffer);

}  // namespace lumatlas
