// SPDX-License-Identifier: GPL-3.0-or-later
// Estimates errors of the given lenses from the photographs. For each lens a correction is estimated by
// Levenberg-Marquardt from how the stored views disagree at surface points: focal length, principal point and k1; then
// k2, and then p1 and p2, each kept only where the points determine it. Views whose cameras have the same size, focal
// lengths and principal point share a lens.
//
// All views' poses and exposures are solved for along with it and marginalised, so a focal length that moving the
// cameras explains as well gets a large deviation and is not significant. The colours that a view is compared with are
// the other views' medians; they change with the correction and with those views' poses, and the derivatives say so.
//
// Along a walk, where each view shares points with its neighbours, time and memory grow with the number of stored
// views. Where all views share points, memory grows with the square of their number, 4 MB at 100 views, and time with
// its cube up to LensOptions::most_operations, with its square beyond, except one factor (kFactorForLenses). The
// capacity of the atlas makes no difference.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/camera/lens_correction.h"
#include "mesh/cancel_check.h"
#include "planner/refinement/joint/joint_cost.h"
#include "planner/refinement/median_colors.h"
#include "planner/refinement/surface_samples.h"

namespace lumatlas {

// Root of the mean robust squared difference, sRGB values of [0, 1], at points that nothing was fitted to; with the
// best poses and exposures for the given lens and for the corrected one.
struct LensResidual {
  double before = 0, after = 0;
};

struct LensEstimate {
  std::vector<ViewSlot> slots;  // the views that share it, ascending
  LensCorrection correction;
  // Standard deviations of the correction's fields, 0 for those that are not estimated. The larger of two: from the
  // residuals' variance, taking the three channels of a point for one measurement; and from how the views' gradients
  // scatter, which stands correlation within a view. Doubled variance in both, because two views that are compared with
  // each other are counted twice.
  LensCorrection deviation{0, {0, 0}, 0, 0, 0, 0};
  LensResidual residual;
  double corner_px = 0;  // the largest distance by which the correction moves a corner
  // The most pixels by which any field alone can move a corner, even 3 deviations further than estimated, also one that
  // was tried and given up; 0 if no fit that was tried lowered the residual at held-out points by half of
  // LensOptions::least_improvement. Where it is below 0.5 px, more points are not expected to make the estimate
  // significant, unless poses were refined with the wrong lens: they hide most of it from few points.
  double most_corner_px = 0;
  // The residual falls by LensOptions::least_improvement or more, and some field of more than 5 deviations moves a
  // corner by more than 0.5 px.
  bool significant = false;
};

struct LensEstimates {
  std::vector<LensEstimate> lenses;  // ascending by their first slot
  std::size_t views = 0;             // that took part
  std::size_t points = 0;            // that were fitted to
  std::size_t unknowns = 0;          // that were solved for together; 0 with no view
  std::vector<Camera> cameras;       // one per view slot: intrinsics as they were, poses refined along
  // A factor would take more than kFactorForLenses times LensOptions::most_operations: nothing was solved, and no lens
  // is significant.
  bool too_large = false;

  // Returns whether any field is significant.
  [[nodiscard]] bool significant() const;
  // Returns whether more points might make the estimate significant.
  [[nodiscard]] bool undecided() const;
};

// Deviations take one factor, where all steps of a solution take 20 to 40. At kMostStepOperations, where all views
// share points, they are found for up to 1,700 views and lenses, with 560 MB.
inline constexpr std::size_t kFactorForLenses = 40;

struct LensOptions {
  AlignmentOptions alignment = {};  // its prior and max_move: how strongly poses are pulled to the given ones
  // Points of each view, evenly taken, >= 1. Time grows with it, and deviations fall with its square root.
  std::size_t most_points = std::numeric_limits<std::size_t>::max();
  std::size_t most_operations = kMostStepOperations;  // see PoseOptions::most_operations
  double least_improvement = 0.01;                    // share of the residual, (0, 1): see LensEstimate::significant
  CancelCheck cancel_check = {};
};

// `views`, `given` (the poses that the views came with) and `samples` by slot: the points at which the view there is
// compared with the views that a sample's cell refers to. A view with fewer than kFewestAlignmentPoints points that
// others show takes no part; with no view that does, the corrections are none, their deviations are 0 and they are not
// significant. Throws std::invalid_argument if an option is out of its range, if there are not as many views, poses and
// lists of samples as the atlas has slots, or if a sample's face is not in the mesh.
[[nodiscard]] LensEstimates estimate_lenses(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
                                            std::span<const Camera> given,
                                            std::span<const std::vector<SurfaceSample>> samples,
                                            const LensOptions& options = {});

}  // namespace lumatlas
