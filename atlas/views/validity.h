// SPDX-License-Identifier: GPL-3.0-or-later
// Marks the pixels of a photograph whose samples are valid: valid() of Erat et al. 2019, section 3.1, second and third
// case, computed once per stored view into a mask instead of per fragment. (The first case, occlusion, needs the
// sample's depth.)
//
// Departures from the print: The image rectangle less the undistortion border takes the place of the cone alpha. The
// depth difference is relative to the depth. Validity fades towards invalid pixels instead of a step, so that no line
// shows where a photograph ends (blend/geometric_weight.h, faded_weight()). Only the farther side of a depth edge is
// invalid, because its colours would stay on the surface behind when the camera moves. The nearer side, the rim of the
// object in front, is valid for pictures from about the same direction (rim_share() there), which show the same rim
// before the same background.
// ValidityOptions::printed() keeps the step and both sides. Pixels that the other views contradict (a passer-by, a leaf
// before the lens), which the paper leaves in, weigh next to nothing.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "atlas/images/photograph.h"

namespace lumatlas {

inline constexpr double kMostDepthEdge = 1e6;         // the largest depth_edge
inline constexpr std::uint32_t kMostEdgePixels = 16;  // the largest edge_radius_px and fade_px

struct ValidityOptions {
  enum class Edges {
    far_side,    // pixels beside one that is nearer
    both_sides,  // and those beside one that is farther, or that shows no surface
  };
  double depth_edge = 0.05;          // a depth step counts as an edge above this share of the nearer depth; (0, 1e6]
  std::uint32_t edge_radius_px = 2;  // Delta_xy: pixels this close to an edge are invalid; [0, 16]
  std::uint32_t fade_px = 3;         // over how many pixels the mask rises from next to 0 to 255; [0, 16], 0: a step
  Edges edges = Edges::far_side;     // which side of an edge is invalid; printed: both

  [[nodiscard]] static ValidityOptions printed();
};

// The names that files and the command line have for them.
inline const std::map<std::string, ValidityOptions::Edges> kEdgesByName = {
    {"both", ValidityOptions::Edges::both_sides},
    {"far", ValidityOptions::Edges::far_side},
};
[[nodiscard]] std::string name_of(ValidityOptions::Edges edges);

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const ValidityOptions& options);

// One value per pixel, row by row: 0 invalid, 255 wholly valid. `depth` is z in the camera frame at the photograph's
// resolution, infinity where no surface is; such pixels are invalid. Throws std::invalid_argument unless the options
// pass check() and `depth` has one value per pixel of the photograph, `trust` and the photograph's `valid` as many or
// none. atlas/README.md has the formula. `trust` is empty or has one value per pixel: 255 trusted, 0 contradicted
// by the other views. The mask without trust is multiplied by max(trust, 1) / 255, but what is above 0 stays at least
// 1: a contradicted pixel is used where no other view is valid, rather than leaving a hole.
[[nodiscard]] std::vector<std::uint8_t> validity_mask(const Photograph& photograph, std::span<const float> depth,
                                                      std::span<const std::uint8_t> trust,
                                                      const ValidityOptions& options);

// One value per pixel: 1 on the nearer side of a depth edge within edge_radius_px, which is valid from about there
// alone; else 0. Empty if both sides of edges are invalid. `depth` and errors as above.
[[nodiscard]] std::vector<std::uint8_t> rim_pixels(const Photograph& photograph, std::span<const float> depth,
                                                   const ValidityOptions& options);

}  // namespace lumatlas
