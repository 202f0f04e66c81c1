// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/picture_shape.h"

#include <algorithm>

namespace lumatlas {

bool same_shape(const ImageSize& a, const ImageSize& b) {
  constexpr std::uint32_t kLeast = 16;
  if (std::min({a.width, a.height, b.width, b.height}) < kLeast) return false;
  const double least = std::max((a.width - 1.0) / b.width, (a.height - 1.0) / b.height);
  const double most = std::min((a.width + 1.0) / b.width, (a.height + 1.0) / b.height);
  constexpr double kSameSize = 0.05;  // a picture of nearly the same size was cut and not scaled
  return least < most && (least > 1 + kSameSize || most < 1 - kSameSize);
}

}  // namespace lumatlas
