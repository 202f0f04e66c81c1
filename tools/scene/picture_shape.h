// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures that are kept at another size than they were taken at.
#pragma once

#include "atlas/images/photograph.h"

namespace lumatlas {

// Returns true if a picture of size `a` may be a picture of size `b` that was scaled by 5 % or more, with width and
// height rounded up or down. Returns false for sides below 16 pixels, which fit too many shapes.
[[nodiscard]] bool same_shape(const ImageSize& a, const ImageSize& b);

}  // namespace lumatlas
