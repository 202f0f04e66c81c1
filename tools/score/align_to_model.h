// SPDX-License-Identifier: GPL-3.0-or-later
// The pose and exposure of a photograph that was held out, refined against what a model shows: its given pose is as
// wrong as any other, and a score at that pose would measure the pose.
#pragma once

#include "atlas/photograph.h"
#include "blend/blend_options.h"
#include "blend/renderer.h"
#include "mesh/visibility.h"
#include "planner/alignment.h"

namespace lumatlas {

// Renders the loaded model at the pose, aligns the photograph to the picture's surface points, and again from there,
// until the pose rests. The camera is the given one if that agrees best.
[[nodiscard]] Camera align_to_model(Renderer& renderer, const Visibility& visibility, const Camera& camera,
                                    const Photograph& photograph, const BlendOptions& blend);

}  // namespace lumatlas
