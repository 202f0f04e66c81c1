// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/stored_depths.h"

namespace lumatlas {

std::vector<double> sampled_depths(const Snapshot& snapshot) {
  constexpr std::size_t kStride = 97;  // a prime, so that it does not fall on the same columns of every row
  const float below = depth_before_far(*snapshot.surface);
  std::vector<double> depths;
  for (const auto& view : snapshot.views) {
    if (!view) continue;
    for (std::size_t pixel = 0; pixel < view->mask->depth.size(); pixel += kStride) {
      if (view->mask->depth[pixel] < below) depths.push_back(static_cast<double>(view->mask->depth[pixel]));
    }
  }
  return depths;
}

}  // namespace lumatlas
