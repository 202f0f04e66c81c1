// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/refinement/joint_refinement.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <limits>
#include <utility>

#include "tools/base/elapsed.h"
#include "tools/pipeline/refinement/joint_limits.h"
#include "tools/pipeline/refinement/lens_refinement.h"
#include "tools/pipeline/refinement/originals.h"
#include "tools/pipeline/refinement/shutter_refinement.h"

namespace lumatlas {

namespace {

// A step that lowers the mean residual by less than this share is the last.
constexpr double kRestingShare = 0.002;

void polish_once(Planner& planner, BuildStage& stage, BuildResult& result) {
  result.polish.push_back(planner.refiner().polish());
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

// Points of all views together.
constexpr std::size_t kPointsTogether = 60000;
// Each estimate is exact to first order only, and is made of photographs that the ones before have corrected. So the
// first one that finds something need not be of all points.
constexpr int kLensRounds = 3, kStraightenings = 3;
constexpr std::size_t kPointsAtFirst = 20000;

bool correct_at_first(const Planner& planner, const BuildOptions& options, LensRefinement& lenses) {
  const auto taken = [&](std::size_t points) {
    return std::min(points_of_each(points, planner.store().stored_views()), options.planner.refinement.samples);
  };
  if (taken(kPointsAtFirst) < taken(kPointsTogether) && lenses.correct(kPointsAtFirst)) return true;
  return lenses.correct(kPointsTogether);
}

// More polishing between the corrections of lenses would move poses to where they hide what a lens gets wrong. Returns
// whether the last round has corrected any, and with them the poses.
bool refine_lenses(Planner& planner, std::vector<SceneView>& views, const BuildOptions& options, BuildStage& stage,
                   BuildResult& result) {
  LensRefinement lenses(planner, views, result.lenses, warning_of_originals(options));
  const bool seem_right = result.polish.back().moved_px == 0 && lenses.seem_right();
  bool corrected = !seem_right && correct_at_first(planner, options, lenses);
  if (lenses.too_large()) result.warnings.push_back(too_large_for_lenses(planner.store().stored_views()));
  stage.tick();
  for (int round = 1; round < kLensRounds && corrected; ++round) {
    polish_once(planner, stage, result);
    corrected = lenses.correct(kPointsTogether);
    stage.tick();
  }
  if (corrected) polish_once(planner, stage, result);
  return corrected;
}

// Exposures and single views follow.
void solve_poses(Planner& planner, BuildStage& stage, BuildResult& result) {
  const std::uint32_t views = planner.store().stored_views();
  if (views == 0) return;
  result.poses = planner.refiner().solve_poses(points_of_each(kPointsTogether, views));
  stage.tick();
  polish_once(planner, stage, result);
}

// A lens was estimated from photographs that motions had bent. What they hid of its error is found after them.
void correct_lenses_further(Planner& planner, std::vector<SceneView>& views, const BuildOptions& options,
                            BuildStage& stage, BuildResult& result) {
  LensRefinement lenses(planner, views, result.lenses, warning_of_originals(options));
  const bool corrected = lenses.correct(kPointsTogether);
  stage.tick();
  if (corrected) polish_once(planner, stage, result);
}

void refine_shutters(Planner& planner, std::vector<SceneView>& views, const BuildOptions& options, BuildStage& stage,
                     BuildResult& result) {
  const std::uint32_t stored = planner.store().stored_views();
  if (stored == 0) return;
  ShutterRefinement shutters(planner, views, warning_of_originals(options));
  for (int round = 0; round < kStraightenings; ++round) {
    const bool straightened = shutters.straighten(points_of_each(kPointsTogether, stored));
    stage.tick();
    if (!straightened) break;
    polish_once(planner, stage, result);
    if (round == 0 && options.refine_lenses) correct_lenses_further(planner, views, options, stage, result);
  }
  result.shutters = shutters.refined();
}

void refine_stored(Planner& planner, std::vector<SceneView>& views, const BuildOptions& options, BuildStage& stage,
                   BuildResult& result) {
  polish_once(planner, stage, result);
  const bool has_new_poses = options.refine_lenses && refine_lenses(planner, views, options, stage, result);
  if (result.polish.back().moved_px == 0) return;
  if (!has_new_poses) solve_poses(planner, stage, result);
  if (options.refine_shutters) refine_shutters(planner, views, options, stage, result);
  polish_until_rest(planner, options, stage, result);
}

}  // namespace

void refine_jointly(Planner& planner, std::vector<SceneView>& views, const BuildOptions& options,
                    const BuildCallback& callback, BuildResult& result) {
  const auto start = std::chrono::steady_clock::now();
  if (options.refine == RefineMode::joint) {
    BuildStage stage(callback, "polishing jointly", 0);
    if (result.effective.refinement.any()) refine_stored(planner, views, options, stage, result);
    stage.finish();
  }
  planner.refiner().publish_refined();
  result.polish_ms = ms_since(start);
}

}  // namespace lumatlas
