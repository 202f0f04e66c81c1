// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/view_depth.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include "mesh/base/median.h"

namespace lumatlas {

double median_depth(const StoredView& view) {
  constexpr std::size_t kStride = 16;
  std::vector<float> depths;
  std::size_t finite = 0;
  for (const float depth : view.depth) {
    if (std::isfinite(depth) && depth > 0 && finite++ % kStride == 0) depths.push_back(depth);
  }
  return depths.empty() ? 0 : upper_median(depths);
}

}  // namespace lumatlas
