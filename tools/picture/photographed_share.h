// SPDX-License-Identifier: GPL-3.0-or-later
// How much of a picture shows what the stored views show too.
#pragma once

#include "atlas/atlas.h"
#include "mesh/camera.h"
#include "mesh/visibility.h"

namespace lumatlas {

// The share of the camera's pixels, looked at coarsely, whose cell refers to a stored view that sees it from within 60
// degrees of where the camera does, and from no more than 2.5 times as far: what is seen from behind, or from so near
// that it is a blur, was not photographed. In [0, 1].
[[nodiscard]] double photographed_share(const Snapshot& snapshot, const Visibility& visibility, const Camera& camera);

}  // namespace lumatlas
