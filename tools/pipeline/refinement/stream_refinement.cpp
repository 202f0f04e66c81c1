// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/refinement/stream_refinement.h"

#include "tools/pipeline/refinement/joint_limits.h"

namespace lumatlas {

namespace {

// Points of all stored views together: half of the number with which all poses are solved once the stream has ended.
constexpr std::size_t kPointsInStream = 30000;
constexpr int kLastRounds = 2;  // rounds for the rest of errors after earlier estimates of lenses

}  // namespace

void StreamRefinement::before_offer(SceneView& view) const {
  for (const RefinedLens& lens : lenses_) {
    if (lens.applied && share_a_lens(view.camera, lens.camera)) view.correction = lens.estimate.correction;
  }
}

// Returns whether any was wrong.
bool StreamRefinement::correct_lenses() {
  has_corrected_ = refinement_.correct(kPointsInStream);
  if (!has_corrected_) next_look_ = 2 * planner_.store().stored_views();
  return has_corrected_;
}

void StreamRefinement::after_offer() {
  const std::uint32_t stored = planner_.store().stored_views();
  const bool wanted = options_.refine == RefineMode::all && options_.planner.refinement.any();
  if (!wanted || stored < next_step_) return;
  next_step_ = stored + stored / 2;
  if (planner_.refiner().at_rest() && (!options_.refine_lenses || refinement_.seem_right())) return;
  const bool can_solve = options_.planner.refinement.alignment.pose && stored > 0;
  const bool look = options_.refine_lenses && stored >= next_look_;
  if (look || !can_solve) (void)planner_.refiner().polish();
  // A corrected lens comes with its poses.
  if ((look && correct_lenses()) || !can_solve) return;
  (void)planner_.refiner().solve_poses(points_of_each(kPointsInStream, stored));
}

void StreamRefinement::finish(const BuildCallback& callback) {
  if (!has_corrected_) return;
  BuildStage stage(callback, "correcting lenses", 0);
  for (int round = 0; round < kLastRounds && has_corrected_; ++round) {
    (void)planner_.refiner().polish();
    (void)correct_lenses();
    stage.tick();
  }
  if (has_corrected_) (void)planner_.refiner().polish();
  stage.finish();
}

}  // namespace lumatlas
