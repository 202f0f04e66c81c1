// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/pose_estimate.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "mesh/base/requirement.h"
#include "planner/refinement/joint/joint_solver.h"

namespace lumatlas {

namespace {

// Levels above the finest one used: a drift of several pixels is beyond what the finest gradients know of.
constexpr std::array<std::uint32_t, 24> kDriftRounds = {3, 3, 3, 3, 3, 2, 2, 2, 2, 2, 2, 2,
                                                        1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0};
constexpr std::array<std::uint32_t, 4> kFinestRounds = {0, 0, 0, 0};  // with the noise of what was found

}  // namespace

PoseEstimate estimate_poses(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
                            std::span<const Camera> given, std::span<const std::vector<SurfaceSample>> samples,
                            const PoseOptions& options) {
  constexpr Requirement pose_estimate_requires{"poses"};
  const JointInput input{atlas, views, given, samples};
  check(input, options.most_points, pose_estimate_requires);
  JointSolver solver(input, {options.alignment, options.most_points, options.most_operations, options.cancel_check});
  PoseEstimate result;
  result.cameras = solver.state().cameras;
  result.views = solver.views();
  result.points = solver.points();
  if (result.views == 0) return result;
  JointState before = solver.state();
  solver.measure_noise();
  solver.refine(kDriftRounds);
  solver.measure_noise();
  solver.refine(kFinestRounds);
  result.cameras = solver.state().cameras;
  result.residual_after = solver.held_out_residual();
  // Exposures are not what is judged.
  const std::vector<double> found_gain = solver.state().gain;
  solver.set_state(before);
  result.residual_before = solver.held_out_residual();
  before.gain = found_gain;
  solver.set_state(before);
  result.residual_before = std::min(result.residual_before, solver.held_out_residual());
  return result;
}

}  // namespace lumatlas
