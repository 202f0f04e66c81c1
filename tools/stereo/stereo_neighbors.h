// SPDX-License-Identifier: GPL-3.0-or-later
// Which photographs to compare each with, and how near and far to look.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "mesh/camera.h"
#include "tools/stereo/patch_match.h"

namespace lumatlas {

struct StereoPlan {
  std::vector<std::size_t> neighbors;  // the best first; empty: no other photograph shows the same
  InverseDepthRange range;             // meaningless without neighbors
  std::vector<DepthSeed> seeds;        // the points that the photograph has seen
};

// One plan a camera. The best neighbors see the same points from some 8 degrees aside, at a like resolution: nearer
// ones tell little of depth, farther ones look different. `views` of each point are the cameras that saw it; where
// nobody has noted that down (all are empty), a point counts as seen by every camera whose picture it is in. Without
// points the space before each camera is probed instead. Cameras and points in one frame.
[[nodiscard]] std::vector<StereoPlan> plan_stereo(std::span<const Camera> cameras, std::span<const glm::dvec3> points,
                                                  std::span<const std::vector<std::uint32_t>> views,
                                                  std::size_t most_neighbors);

}  // namespace lumatlas
