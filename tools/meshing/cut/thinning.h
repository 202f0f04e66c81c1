// SPDX-License-Identifier: GPL-3.0-or-later
// Fewer points: those that no photograph tells apart become one.
#pragma once

#include <cstddef>
#include <span>

#include "mesh/camera/camera.h"
#include "tools/scene/scene_points.h"

namespace lumatlas {

// Points closer together than `spacing_px` pixels of the nearest view that saw them are one: the one that most views
// saw, the first of several, which is then seen by the views of all. Points that no view saw are dropped. Positions in
// the frame of the cameras. Throws std::invalid_argument for a spacing that is not finite or negative.
[[nodiscard]] ScenePoints thinned(const ScenePoints& points, std::span<const Camera> views, double spacing_px);

}  // namespace lumatlas
