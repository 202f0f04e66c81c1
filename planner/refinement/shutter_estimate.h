// SPDX-License-Identifier: GPL-3.0-or-later
// Estimates from the photographs how each camera moved while its rolling shutter read the picture. The motions of all
// stored views are solved for together with their poses and exposures, from how the views disagree at surface points.
//
// A weak pull keeps motions small that the points do not determine. The estimate knows the depth of each point; where a
// photograph is straightened, all that it shows counts as being at its median depth, of which shifts are multiples.
//
// Time and memory: as estimate_lenses(), with twice the unknowns for each view.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/camera/camera.h"
#include "mesh/camera/shutter_motion.h"
#include "mesh/cancel_check.h"
#include "planner/refinement/joint/joint_cost.h"
#include "planner/refinement/lens_estimate.h"
#include "planner/refinement/median_colors.h"
#include "planner/refinement/surface_samples.h"

namespace lumatlas {

struct ShutterOptions {
  AlignmentOptions alignment = {};  // its prior and max_move: how strongly poses are pulled to the given ones
  // Points of each view, evenly taken, >= 1. Time grows with it.
  std::size_t most_points = std::numeric_limits<std::size_t>::max();
  std::size_t most_operations = kMostStepOperations;  // see PoseOptions::most_operations
  // Share of the residual, (0, 1): see ShutterEstimate::significant. Smaller motions are better left: photographs taken
  // one after the other are bent alike, so that one that is straightened no longer fits its neighbour.
  double least_improvement = 0.05;
  CancelCheck cancel_check = {};
};

struct ShutterEstimate {
  std::vector<ShutterMotion> motions;  // one per view slot, of points at the depth 1
  std::vector<Camera> cameras;         // one per view slot: intrinsics as they were, poses refined along
  std::size_t views = 0;               // that took part
  std::size_t points = 0;              // that were fitted to
  LensResidual residual;               // with the best poses and exposures: without motions, and with them
  double median_px = 0;                // median over the views of edge_move_px()
  // The residual falls by ShutterOptions::least_improvement or more, and the median is at least half a pixel.
  bool significant = false;
};

// Takes and refuses the same as estimate_lenses(), and leaves lenses as they are.
[[nodiscard]] ShutterEstimate estimate_shutters(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
                                                std::span<const Camera> given,
                                                std::span<const std::vector<SurfaceSample>> samples,
                                                const ShutterOptions& options = {});

}  // namespace lumatlas
