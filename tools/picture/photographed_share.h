// SPDX-License-Identifier: GPL-3.0-or-later
// Measures which share of a picture shows what stored views show too.
#pragma once

#include "atlas/atlas.h"
#include "mesh/camera/camera.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// The share of the camera's pixels, looked at coarsely, that show what was photographed, in
// [0, 1]: see tools/picture/paths/kept_path.h.
[[nodiscard]] double photographed_share(const Snapshot& snapshot, const Visibility& visibility, const Camera& camera);

}  // namespace lumatlas
