// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/joint_refinement.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <limits>
#include <string>

#include "tools/base/elapsed.h"
#include "tools/pipeline/lens_notes.h"

namespace lumatlas {

namespace {

// A step that lowers the mean residual by less than this share is the last.
constexpr double kRestingShare = 0.002;

void polish_once(Planner& planner, BuildStage& stage, BuildResult& result) {
  result.polish.push_back(planner.polish());
  stage.tick();
}

void polish_until_rest(Planner& planner, const BuildOptions& options, BuildStage& stage, BuildResult& result) {
  double last = result.polish.empty() ? std::numeric_limits<double>::infinity() : result.polish.back().residual_after;
  while (result.polish.size() < options.max_polish_steps) {
    polish_once(planner, stage, result);
    if (result.polish.back().moved_px == 0) break;  // all are where they were given: another step finds the same
    const double residual = result.polish.back().residual_after;
    if (!(residual < (1 - kRestingShare) * last)) break;
    last = residual;
  }
}

// The estimate's time grows with the cube of this: some ten seconds.
constexpr std::uint32_t kMostViewsForLenses = 400;
// Of all views together.
constexpr std::size_t kPointsForLenses = 60000;
constexpr std::size_t kFewestPointsOfView = 300;
// For a first look where no view had to move, which is enough where it shows that no lens is wrong. Poses that moved
// may have taken up most of what a lens gets wrong, and few points then do not show the rest.
constexpr std::size_t kPointsForFirstLook = 4000;
constexpr std::size_t kFewestPointsOfFirstLook = 100;
// Each estimate is exact to first order only, and is made of photographs that the ones before have corrected.
constexpr int kLensRounds = 3;
// Of the residual, of a lens that is known to be wrong: what is left of its error improves less than all of it.
constexpr double kLeastFurtherImprovement = 0.003;

// Adds what an estimate found to what is known of the lenses.
void note_lenses(const LensEstimates& estimates, std::vector<RefinedLens>& lenses) {
  if (lenses.empty()) {
    for (const LensEstimate& estimate : estimates.lenses) {
      lenses.push_back({estimates.cameras[estimate.slots.front()], estimate.slots.size(), estimate, false});
    }
  }
  for (std::size_t i = 0; i < lenses.size(); ++i) {
    const LensEstimate& estimate = estimates.lenses[i];
    if (!estimate.significant) continue;
    LensEstimate& sum = lenses[i].estimate;
    if (lenses[i].applied) {
      sum.correction = combined(sum.correction, estimate.correction);
      sum.deviation = estimate.deviation;
      sum.residual.after = estimate.residual.after;
      sum.corner_px = corner_move_px(sum.correction, lenses[i].camera);
    }
    lenses[i].applied = true;
  }
}

// Lenses that nothing was wrong with so far must improve as much as ever to be believed wrong.
void ask_more_of_others(const std::vector<RefinedLens>& lenses, LensEstimates& estimates) {
  for (std::size_t i = 0; i < lenses.size(); ++i) {
    LensEstimate& estimate = estimates.lenses[i];
    const double least = lenses[i].applied ? kLeastFurtherImprovement : LensOptions{}.least_improvement;
    estimate.significant = estimate.significant && estimate.residual.after <= (1 - least) * estimate.residual.before;
  }
}

// Estimates the lenses, undistorts the stored photographs again by those that are plainly wrong, from the originals,
// and polishes once; until nothing is wrong any more. More polishing in between would move poses to where they hide
// what a lens gets wrong.
void refine_lenses(Planner& planner, std::vector<SceneView>& views, BuildStage& stage, BuildResult& result) {
  if (planner.stored_views() == 0 || planner.stored_views() > kMostViewsForLenses) return;
  LensOptions lens_options;
  if (result.polish.back().moved_px == 0) {
    lens_options.most_points = std::max(kFewestPointsOfFirstLook, kPointsForFirstLook / planner.stored_views());
    if (const LensEstimates first = planner.estimate_lenses(lens_options); !first.undecided()) {
      stage.tick();
      return note_lenses(first, result.lenses);
    }
  }
  lens_options.most_points = std::max(kFewestPointsOfView, kPointsForLenses / planner.stored_views());
  for (int round = 0; round < kLensRounds; ++round) {
    LensEstimates estimates = planner.estimate_lenses(lens_options);
    stage.tick();
    ask_more_of_others(result.lenses, estimates);
    note_lenses(estimates, result.lenses);
    if (!estimates.significant()) return;
    lens_options.least_improvement = kLeastFurtherImprovement;
    correct_lenses(views, result.lenses);
    planner.correct_lenses(estimates, [&](std::uint32_t, const std::string& name) {
      return load_photograph(
          *std::find_if(views.begin(), views.end(), [&](const SceneView& v) { return v.name == name; }));
    });
    polish_once(planner, stage, result);
  }
}

}  // namespace

void refine_jointly(Planner& planner, std::vector<SceneView>& views, const BuildOptions& options,
                    const BuildCallback& callback, BuildResult& result) {
  const auto start = std::chrono::steady_clock::now();
  if (options.refine == RefineMode::joint) {
    BuildStage stage(callback, "polishing jointly", 0);
    if (options.refine_lenses && result.effective.refinement.any()) {
      polish_once(planner, stage, result);
      refine_lenses(planner, views, stage, result);
    }
    if (result.polish.empty() || result.polish.back().moved_px > 0) {
      polish_until_rest(planner, options, stage, result);
    }
    stage.finish();
  }
  planner.settle();
  result.polish_ms = ms_since(start);
}

}  // namespace lumatlas
