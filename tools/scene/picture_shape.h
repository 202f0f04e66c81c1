// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures that are kept at another size than they were taken at.
#pragma once

#include "atlas/photograph.h"

namespace lumatlas {

// Whether a picture of size `a` may be one of size `b` that was scaled by 5 % or more, with its sizes rounded up or
// down. Sizes below 16 pixels fit too many shapes: then it is false.
[[nodiscard]] bool same_shape(const ImageSize& a, const ImageSize& b);

}  // namespace lumatlas
