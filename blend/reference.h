// SPDX-License-Identifier: GPL-3.0-or-later
// The renderer's CPU reference: the same formula in double precision and plain loops, against which the shader is
// tested.
#pragma once

#include "atlas/snapshot.h"
#include "blend/blend_options.h"
#include "blend/diagnosis.h"
#include "blend/rendering.h"
#include "mesh/camera/camera.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// One sample a pixel, at its middle, whatever options.supersample says. `visible` is what the camera sees at its own
// resolution. Throws std::invalid_argument unless snapshot, camera and options pass check(), and `visible` has a depth
// and a face, of the snapshot's mesh or FaceId::none, for each pixel of the camera's image.
[[nodiscard]] Rendering render_reference(const Snapshot& snapshot, const Camera& camera,
                                         const VisibilityBuffer& visible, const BlendOptions& options);

// With as many samples a pixel as options.supersample says, by what each of them sees. Throws std::invalid_argument
// unless snapshot, camera and options pass check().
[[nodiscard]] Rendering render_reference(const Snapshot& snapshot, const Camera& camera, const Visibility& visibility,
                                         const BlendOptions& options);

// Returns the views and weights at the middles of the pixels. Throws what the first render_reference() throws.
[[nodiscard]] Diagnosis diagnose_reference(const Snapshot& snapshot, const Camera& camera,
                                           const VisibilityBuffer& visible, const BlendOptions& options);

}  // namespace lumatlas
