// SPDX-License-Identifier: GPL-3.0-or-later
// Where in a photograph a sample may be trusted: valid() of Erat et al. 2019, section 3.1, second and third case,
// computed once per stored view into a mask instead of per fragment. (The first case, occlusion, needs the sample's
// depth.)
//
// Departures from the print: the image rectangle less the undistortion border instead of the cone alpha; the depth
// difference relative to the depth; and a fade towards invalid pixels instead of a step, so that no seam shows where a
// photograph ends. ValidityOptions::printed() keeps the step. And pixels that the other views contradict (a passer-by,
// a leaf before the lens), which the paper leaves in, weigh next to nothing.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "atlas/photograph.h"

namespace lumatlas {

struct ValidityOptions {
  double depth_edge = 0.05;          // a depth step counts as an edge above this share of the nearer depth; finite, > 0
  std::uint32_t edge_radius_px = 2;  // Delta_xy: pixels this close to an edge are invalid; [0, 16]
  std::uint32_t fade_px = 2;         // over how many pixels the mask rises from 0 to 255; [0, 255], 0: a step

  [[nodiscard]] static ValidityOptions printed();
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const ValidityOptions& options);

// One value per pixel, row by row: 0 invalid, 255 wholly valid. `depth` is z in the camera frame at the photograph's
// resolution, infinity where no surface is; such pixels are invalid. `trust` is empty or has one value per pixel: 255
// trusted, 0 contradicted by the other views. The mask without trust is multiplied by max(trust, 1) / 255, but what is
// above 0 stays at least 1: a contradicted pixel is used where no other view is valid, rather than leaving a hole.
[[nodiscard]] std::vector<std::uint8_t> validity_mask(const Photograph& photograph, std::span<const float> depth,
                                                      std::span<const std::uint8_t> trust,
                                                      const ValidityOptions& options);

}  // namespace lumatlas
