// SPDX-License-Identifier: GPL-3.0-or-later
// Finds what a camera close to a stored view sees, from the view's depth instead of by rays.
#pragma once

#include "atlas/views/stored_view.h"
#include "mesh/camera/camera.h"
#include "mesh/visibility/visibility.h"
#include "planner/coverage/seen_faces.h"

namespace lumatlas {

// `faces`: of the view's image. Depth is interpolated where the surface is smooth. The camera must be within a few
// pixels of the view's: surface that only one of the two sees, beside an edge or at the image's border, has another
// surface's depth, or none. Throws std::invalid_argument for a bad camera (camera.h).
[[nodiscard]] VisibilityBuffer seen_nearby(const StoredView& view, const FaceLookup& faces, const Camera& camera);

}  // namespace lumatlas
