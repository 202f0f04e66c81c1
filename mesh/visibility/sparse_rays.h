// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: visibility with a ray for every second pixel of every second row, and for others only where the
// surface is not smooth.
#pragma once

#include <cstdint>
#include <span>

#include "mesh/camera.h"
#include "mesh/visibility/embree_scene.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// Implements Visibility::trace_sparsely(), and RayVisibility::trace_part() unless `wanted` is empty. The buffer has the
// camera's size. The result is the same on any number of threads.
void trace_sparsely(const Camera& camera, RTCScene scene, std::span<const std::uint8_t> wanted,
                    VisibilityBuffer& buffer);

}  // namespace lumatlas
