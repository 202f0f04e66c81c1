// SPDX-License-Identifier: GPL-3.0-or-later
// The poses of all stored views at once. View by view, each is held by its neighbours: a drift that many share takes
// hundreds of steps to undo, and one solution here.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/camera/camera.h"
#include "mesh/cancel_check.h"
#include "planner/refinement/joint/joint_cost.h"
#include "planner/refinement/median_colors.h"
#include "planner/refinement/surface_samples.h"

namespace lumatlas {

struct PoseOptions {
  AlignmentOptions alignment = {};  // its prior and max_move: how strongly poses are pulled to the given ones
  // Points of each view, evenly taken, >= 1. Time grows with it.
  std::size_t most_points = std::numeric_limits<std::size_t>::max();
  // Operations on tiles of the normal equations that a factor may take for each step: see kMostStepOperations.
  std::size_t most_operations = kMostStepOperations;
  CancelCheck cancel_check = {};
};

struct PoseEstimate {
  std::vector<Camera> cameras;  // one per view slot: intrinsics as they were
  std::size_t views = 0;        // that took part
  std::size_t points = 0;       // that were fitted to
  // Roots of the mean robust squared difference, sRGB values of [0, 1], at points that were not fitted to. The first is
  // that of the former poses, with the former or the found exposures, whichever is better. The second is that of the
  // found poses and exposures. Both are 0 if no view took part.
  double residual_before = 0, residual_after = 0;

  [[nodiscard]] bool improves() const { return residual_after < residual_before; }
};

// Poses and exposures, with lenses as they are; for the rest, time and memory too, as estimate_lenses().
[[nodiscard]] PoseEstimate estimate_poses(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
                                          std::span<const Camera> given,
                                          std::span<const std::vector<SurfaceSample>> samples,
                                          const PoseOptions& options = {});

}  // namespace lumatlas
