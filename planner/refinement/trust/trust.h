// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the pixels of a photograph that contradict the other views of the same surface (a passer-by, a leaf before the
// lens). Such pixels get little trust, so that they are blended only where no other view is valid.
//
// A highlight is the reason for a lumigraph and must stay. It adds light, so a pixel that is darker than the others in
// some channel is no highlight; one that is overexposed in some channels is not darker there. A pixel that is brighter
// in all channels is contradicted only by views from nearly the same direction, which would show the highlight too.
// Where the mesh is wrong, views that stand together agree with each other and with no other view. So the others must
// agree over half as wide an angle as the nearest of them is away. The paper has no such masks.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/visibility/visibility.h"
#include "planner/refinement/median_colors.h"

namespace lumatlas {

struct TrustOptions {
  bool enabled = true;
  std::uint32_t grid_px = 160;     // longer side of the image in which views are compared, >= 8
  double least_difference = 0.15;  // a contradiction differs by more, in square roots of linear light, in (0, 1]
  double least_to_spread = 3;      // and by more than this many times the others' own median deviation, >= 0
  std::uint32_t least_views = 2;   // other views that it takes, >= 1
  double comparable_deg = 30;      // only views from within this angle are evidence at all, [0, 180]
  double highlight_deg = 10;       // views within this angle would show the same highlight, [0, 180]
};

// What a mask is for.
enum class TrustExtent : std::uint8_t {
  // While poses are still refined: what is masked is not compared any more, so that a mask of what only looks
  // contradicted because a pose is wrong keeps the pose wrong.
  blocks,
  // Once poses are final. What is contradicted block by block is completed to regions (trust_regions.h), because an
  // occluder is solid. A channel that is overexposed in another view tells that the surface is at least as bright: a
  // leaf before a white sky is contradicted.
  regions,
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const TrustOptions& options);

// One value per pixel of the view, 255 trusted, 0 contradicted, soft edges between; empty: trusted everywhere.
// `gain` takes the photograph's linear light to the common exposure, a factor for each channel. `views` by slot of the
// atlas, as many as it has; `self` is the view's own slot there, if it has one. `visible` is what the camera sees at
// any resolution. Throws std::invalid_argument if the number of views is another, if the photograph's size is not the
// camera's, if the options do not pass check(), or if `visible` is empty or not filled.
[[nodiscard]] std::vector<std::uint8_t> trust_mask(const Camera& camera, const Pyramid& photograph,
                                                   const glm::dvec3& gain, const VisibilityBuffer& visible,
                                                   const Atlas& atlas,
                                                   std::span<const std::optional<ComparedView>> views,
                                                   std::optional<ViewSlot> self, const TrustOptions& options,
                                                   TrustExtent extent);

}  // namespace lumatlas
