// SPDX-License-Identifier: GPL-3.0-or-later
// The surface points that the photographs of a scene agree on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "tools/stereo/scene_stereo.h"

namespace lumatlas {

// One entry a point in each list.
struct StereoPoints {
  std::vector<glm::dvec3> positions;              // in the frame of the cameras
  std::vector<float> deviations;                  // standard deviation along the line of sight, scene units
  std::vector<std::vector<std::uint32_t>> views;  // that saw it, by their places in SceneStereo::views(), ascending
};

// Returns at most one point for each square of `block_px` pixels of a matched photograph, >= 1. A square that a point
// of an earlier photograph falls into, and confirms, gives none. Call it after stereo.match(). `progress` is called
// after each photograph; what it throws ends the work. Throws InputError as SceneStereo::depth().
[[nodiscard]] StereoPoints stereo_points(const SceneStereo& stereo, std::uint32_t block_px,
                                         const std::function<void(std::size_t)>& progress);

}  // namespace lumatlas
