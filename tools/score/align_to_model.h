// SPDX-License-Identifier: GPL-3.0-or-later
// The pose and exposure of a photograph that was held out, refined against what a model shows: its given pose is as
// wrong as any other, and a score at that pose would measure the pose.
#pragma once

#include <functional>

#include "atlas/photograph.h"
#include "mesh/visibility.h"
#include "planner/alignment.h"

namespace lumatlas {

// Renders the model at the pose, aligns the photograph to the picture's surface points, and again from there, until the
// pose rests. The camera is the given one if that agrees best.
[[nodiscard]] Camera align_to_model(const std::function<Photograph(const Camera&)>& render,
                                    const Visibility& visibility, const Camera& camera, const Photograph& photograph);

}  // namespace lumatlas
