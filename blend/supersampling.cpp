// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/supersampling.h"

namespace lumatlas {

std::vector<Camera> sample_cameras(const Camera& camera, std::uint32_t across) {
  std::vector<Camera> cameras;
  for (std::uint32_t row = 0; row < across; ++row) {
    for (std::uint32_t column = 0; column < across; ++column) {
      Camera& sample = cameras.emplace_back(camera);
      sample.cx -= (column + 0.5) / across - 0.5;
      sample.cy -= (row + 0.5) / across - 0.5;
    }
  }
  return cameras;
}

BlendOptions at_middle(const BlendOptions& options) {
  BlendOptions middle = options;
  middle.supersample = 1;
  return middle;
}

}  // namespace lumatlas
