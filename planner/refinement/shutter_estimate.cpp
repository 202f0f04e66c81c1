// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/shutter_estimate.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "mesh/base/median.h"
#include "mesh/base/requirement.h"
#include "planner/refinement/joint/joint_solver.h"

namespace lumatlas {

namespace {

// Levels above the finest one used.
constexpr std::array<std::uint32_t, 8> kRoundsAtRest = {1, 1, 0, 0, 0, 0, 0, 0};
constexpr std::array<std::uint32_t, 10> kShutterRounds = {2, 1, 1, 1, 0, 0, 0, 0, 0, 0};
constexpr std::array<std::uint32_t, 8> kLastShutterRounds = {0, 0, 0, 0,
                                                             0, 0, 0, 0};  // with the noise of what was found
constexpr double kLeastShutterPx = 0.5;                                    // see ShutterEstimate::significant

}  // namespace

ShutterEstimate estimate_shutters(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
                                  std::span<const Camera> given, std::span<const std::vector<SurfaceSample>> samples,
                                  const ShutterOptions& options) {
  constexpr Requirement shutter_estimate_requires{"shutters"};
  check_least_improvement(options.least_improvement, shutter_estimate_requires);
  const JointInput input{atlas, views, given, samples};
  check(input, options.most_points, shutter_estimate_requires);
  JointSolver solver(input, {options.alignment, options.most_points, options.most_operations, options.cancel_check});
  ShutterEstimate result;
  result.motions.resize(views.size());
  result.cameras = solver.state().cameras;
  result.views = solver.views();
  result.points = solver.points();
  if (result.views == 0) return result;
  solver.measure_noise();
  solver.refine(kRoundsAtRest);
  const JointState at_rest = solver.state();
  solver.estimate_motions();
  solver.refine(kShutterRounds);
  solver.measure_noise();
  solver.refine(kLastShutterRounds);
  const JointState found = solver.state();
  result.residual.after = solver.held_out_residual();
  solver.set_state(at_rest);
  result.residual.before = solver.held_out_residual();
  solver.set_state(found);
  result.cameras = solver.state().cameras;
  std::vector<double> moves;
  for (ViewSlot slot{0}; slot < views.size(); ++slot) {
    if (!views[slot] || !solver.takes_part(slot)) continue;
    result.motions[slot] = motion_of(solver.state().motion[slot], 1);
    moves.push_back(edge_move_px(result.motions[slot], result.cameras[slot]));
  }
  if (!moves.empty()) result.median_px = upper_median(moves);
  result.significant = result.residual.after <= (1 - options.least_improvement) * result.residual.before &&
                       result.median_px >= kLeastShutterPx;
  return result;
}

}  // namespace lumatlas
