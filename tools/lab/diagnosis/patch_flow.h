// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the move after which a patch of one photograph looks like a patch of another: Lucas and Kanade 1981, with a
// gain and an offset of brightness, coarse to fine.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <optional>

#include "planner/refinement/pyramid.h"

namespace lumatlas {

struct PatchFlowOptions {
  std::uint32_t radius_px = 7;      // of the patch; as many steps of 2^level pixels at coarser levels, [2, 32]
  std::uint32_t levels = 3;         // of the photographs, the finest among them, [1, 6]
  double most_px = 8;               // longest flow that counts, pixels, > 0
  double least_correlation = 0.8;   // of the patches after the move, from which it counts, (0, 1]
  double most_deviation_px = 0.15;  // standard deviation of the flow, from contrast and what differs still, pixels, > 0
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const PatchFlowOptions& options);

// Returns where the second photograph shows what the first shows at an image position, if the surface and the cameras
// are right; none where one of them shows something else.
using Carried = std::function<std::optional<glm::dvec2>(const glm::dvec2& image)>;

// Returns the flow of the patch around `image`, in pixels of the second photograph; none if it does not count: too
// little texture in one direction at least, too little in common, too far, or most of the patch not shown.
[[nodiscard]] std::optional<glm::dvec2> patch_flow(const Pyramid& first, const Pyramid& second, const glm::dvec2& image,
                                                   const Carried& carried, const PatchFlowOptions& options);

}  // namespace lumatlas
