// SPDX-License-Identifier: GPL-3.0-or-later
// The renderer's CPU reference: the same formula in double precision and plain loops, against which the shader is
// tested.
#pragma once

#include "atlas/atlas.h"
#include "blend/blend_options.h"
#include "blend/diagnosis.h"
#include "blend/rendering.h"
#include "mesh/camera.h"
#include "mesh/visibility.h"

namespace lumatlas {

// One sample a pixel, at its middle, whatever options.supersample says. `visible` is what the camera sees at its own
// resolution. Throws std::invalid_argument for bad options or another size.
[[nodiscard]] Rendering render_reference(const Snapshot& snapshot, const Camera& camera,
                                         const VisibilityBuffer& visible, const BlendOptions& options);

// The same with options.supersample, by what each sample sees. Throws std::invalid_argument for bad options.
[[nodiscard]] Rendering render_reference(const Snapshot& snapshot, const Camera& camera, const Visibility& visibility,
                                         const BlendOptions& options);

// What the picture is made of at the middles of its pixels. Throws the same.
[[nodiscard]] Diagnosis diagnose_reference(const Snapshot& snapshot, const Camera& camera,
                                           const VisibilityBuffer& visible, const BlendOptions& options);

}  // namespace lumatlas
