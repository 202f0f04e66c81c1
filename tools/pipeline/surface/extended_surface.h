// SPDX-License-Identifier: GPL-3.0-or-later
// Extends a surface by guesses: across its holes and beyond its ends, where photographs show something that neither the
// mesh nor matched photographs have a depth for.
#pragma once

#include <cstddef>
#include <vector>

#include "mesh/mesh.h"
#include "mesh/visibility/visibility.h"
#include "tools/pipeline/surface/far_background.h"

namespace lumatlas {

// Returns the faces that extend `surface`; empty where none make pictures better.
//
// In each photograph, the depths around the pixels that see neither the surface nor the far sphere are continued into
// them (filled_depth.h), and the continuation becomes faces. Photographs that lack most come first; a later one adds
// faces only where it does not see those of the ones before. Vertices that stand before what other photographs see are
// left out. Then each photograph is predicted without itself (frame_prediction.h), once with the faces and once with
// the fill that pictures have there. Faces stay, square by square, where the prediction is clearly the better one.
//
// `far`: null if there is no far sphere. The result does not depend on the number of threads. Throws Interrupted soon
// after a signal.
[[nodiscard]] Mesh surface_extension(const std::vector<SmallPhotograph>& photographs, const Mesh& surface,
                                     const Visibility& visibility, const Visibility* far);

}  // namespace lumatlas
