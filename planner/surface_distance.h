// SPDX-License-Identifier: GPL-3.0-or-later
// Measures the distance of a scene's cameras from its surface.
#pragma once

#include <span>

#include "mesh/camera/camera.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// Median depth, scene units, of what the cameras see: the scene's natural length, for CoverageOptions::ideal_distance.
// Looks at 16 cameras or fewer, evenly spaced, at low resolution; at others only until one sees the mesh, where those
// do not. Above 0. Throws InputError if none does or if the cameras stand on what they see, std::invalid_argument for a
// camera that does not pass check().
[[nodiscard]] double median_surface_distance(std::span<const Camera> cameras, const Visibility& visibility);

}  // namespace lumatlas
