// SPDX-License-Identifier: GPL-3.0-or-later
// Full panoramas in a capture: no plane holds what they see, so each becomes six views.
#pragma once

#include "tools/scene/forms/capture.h"

namespace lumatlas {

// Puts six photographs in the place of each one whose lens is LensModel::kEquirectangular: the faces of a cube around
// the camera, which overlap by a twentieth at each side, as sharp as the panorama is in their middle. Their names are
// the panorama's with /front, /right, /back, /left, /up and /down; each has a pinhole lens, a pose of its own, and
// PosedPhotograph::panorama. A note says how many there are. Sorts by name again.
void cut_panoramas(Capture& capture);

}  // namespace lumatlas
