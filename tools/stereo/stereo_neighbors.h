// SPDX-License-Identifier: GPL-3.0-or-later
// Chooses the photographs that each photograph is compared with, and the range of depths to search.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "mesh/camera/camera.h"
#include "tools/stereo/patch_match.h"

namespace lumatlas {

struct StereoPlan {
  std::vector<std::size_t> neighbors;  // the best first; empty: no other photograph shows the same
  InverseDepthRange range;             // meaningless without neighbors
  std::vector<DepthSeed> seeds;        // the points that the photograph has seen
};

// Returns one plan a camera. The best neighbours see the same points at a triangulation angle of about 8 degrees and a
// similar resolution: smaller angles give inexact depths, larger ones different appearance. `views`: for each point,
// the indices of the cameras that saw it; if all lists are empty, a point counts as seen by every camera whose image it
// falls into. Without points, a grid in front of each camera takes their place. Cameras and points share one frame.
[[nodiscard]] std::vector<StereoPlan> plan_stereo(std::span<const Camera> cameras, std::span<const glm::dvec3> points,
                                                  std::span<const std::vector<std::uint32_t>> views,
                                                  std::size_t most_neighbors);

}  // namespace lumatlas
