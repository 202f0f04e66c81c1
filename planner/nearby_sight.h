// SPDX-License-Identifier: GPL-3.0-or-later
// What a camera close to a stored view sees, from the view's depth instead of by rays.
#pragma once

#include <cstdint>
#include <span>

#include "atlas/stored_view.h"
#include "mesh/camera.h"
#include "mesh/visibility.h"

namespace lumatlas {

// `face`: what each pixel of the view shows, as in VisibilityBuffer. Depth is interpolated where the surface is smooth.
// The camera must be within a few pixels of the view's: what only one of the two sees, beside an edge or at the image's
// border, gets another surface's depth, or none. Throws std::invalid_argument for a bad camera (camera.h), or unless
// `face` has one value per pixel of the view.
[[nodiscard]] VisibilityBuffer seen_nearby(const StoredView& view, std::span<const std::uint32_t> face,
                                           const Camera& camera);

}  // namespace lumatlas
