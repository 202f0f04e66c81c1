// SPDX-License-Identifier: GPL-3.0-or-later
// Measures how far apart the stored photographs show the same points of the surface.
//
// A patch of each photograph is carried over the surface into the view that the renderer would show first in its place.
// The flow is the move, in pixels of that other photograph, after which the two look alike. A wrong depth of the
// surface moves a patch along the epipolar line of its point, and nothing else moves all patches along these lines
// alone: so the part of the flow across them measures errors of poses and lenses, and what is left along them errors of
// the surface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "atlas/snapshot.h"
#include "mesh/cancel_check.h"
#include "tools/lab/diagnosis/patch_flow.h"

namespace lumatlas {

struct ViewFlowOptions {
  std::uint32_t patches_per_view = 1500;  // evenly spread over a photograph, >= 1
  double least_angle_deg = 1;  // between the directions of the two photographs; less tells nothing of depth, (0, 90)
  PatchFlowOptions patch;
  CancelCheck cancel_check;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const ViewFlowOptions& options);

// The flow of one patch.
struct FlowOfPatch {
  ViewSlot first, second;
  glm::dvec2 image;   // the patch's middle in the first photograph, pixels
  glm::dvec2 move;    // in the second photograph, its pixels
  double along = 0;   // the part of the move along the epipolar line, > 0 if the surface is farther than its true place
  double across = 0;  // the part at right angles to that
};

struct ViewFlow {
  std::size_t shown = 0;                   // patches that a second view shows
  std::vector<std::size_t> shown_by_view;  // the same by first view slot
  std::vector<FlowOfPatch> flows;          // of the patches that count (patch_flow.h), by first view slot, row by row
};

// The result does not depend on the number of threads. Throws std::invalid_argument unless snapshot and options pass
// check().
[[nodiscard]] ViewFlow view_flow(const Snapshot& snapshot, const ViewFlowOptions& options = {});

}  // namespace lumatlas
