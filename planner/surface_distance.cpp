// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/surface_distance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/median.h"

namespace lumatlas {

namespace {

constexpr std::size_t kDistanceSamples = 16;
constexpr std::uint32_t kDistanceImagePx = 160;

}  // namespace

double median_surface_distance(std::span<const Camera> cameras, const Visibility& visibility) {
  std::vector<float> depths;
  VisibilityBuffer buffer;
  const std::size_t samples = std::min(kDistanceSamples, cameras.size());
  const auto look = [&](const Camera& camera) {
    check(camera);
    visibility.trace(camera.shrunk_to(kDistanceImagePx), buffer);
    std::copy_if(buffer.depth.begin(), buffer.depth.end(), std::back_inserter(depths),
                 [](float depth) { return std::isfinite(depth); });
  };
  for (std::size_t i = 0; i < samples; ++i) look(cameras[i * cameras.size() / samples]);
  for (std::size_t i = 0; i < cameras.size() && depths.empty(); ++i) look(cameras[i]);
  if (depths.empty()) {
    throw InputError("none of the cameras sees the mesh (" + std::to_string(cameras.size()) +
                     " were asked): give the mesh in the cameras' coordinates");
  }
  const auto median = static_cast<double>(upper_median(depths));
  if (!(median > 0)) {
    throw InputError(
        "the cameras stand on the mesh: half of what they see is at no distance, give the mesh in their coordinates "
        "and "
        "units");
  }
  return median;
}

}  // namespace lumatlas
