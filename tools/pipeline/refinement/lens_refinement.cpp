// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/refinement/lens_refinement.h"

#include <algorithm>
#include <memory>
#include <string>

#include "mesh/base/errors.h"
#include "tools/pipeline/refinement/joint_limits.h"
#include "tools/pipeline/refinement/lens_notes.h"
#include "tools/pipeline/refinement/originals.h"

namespace lumatlas {

namespace {

// Points for LensRefinement::seem_right().
constexpr std::size_t kPointsForFirstLook = 4000;
constexpr std::size_t kFewestPointsOfFirstLook = 100;
// Improvement of the residual for a lens that is known to be wrong: the rest of its error improves it less than all of
// it did.
constexpr double kLeastFurtherImprovement = 0.003;

double least_improvement(const RefinedLens& lens) {
  return lens.applied ? kLeastFurtherImprovement : LensOptions{}.least_improvement;
}

// Adds a further estimate to the correction that was applied.
void add(const LensEstimate& further, RefinedLens& lens) {
  LensEstimate& sum = lens.estimate;
  sum.correction = combined(sum.correction, further.correction);
  sum.deviation = further.deviation;
  sum.residual.after = further.residual.after;
  sum.corner_px = corner_move_px(sum.correction, lens.camera);
}

}  // namespace

RefinedLens& LensRefinement::lens_of(const Camera& camera) {
  const auto known = std::find_if(lenses_.begin(), lenses_.end(),
                                  [&](const RefinedLens& lens) { return share_a_lens(lens.camera, camera); });
  if (known != lenses_.end()) return *known;
  lenses_.push_back({camera, 0, {}, false});
  return lenses_.back();
}

void LensRefinement::note(const LensEstimates& estimates) {
  for (const LensEstimate& estimate : estimates.lenses) {
    RefinedLens& lens = lens_of(estimates.cameras[estimate.slots.front()]);
    if (!lens.applied) {
      lens.estimate = estimate;
      lens.applied = estimate.significant;
    } else if (estimate.significant) {
      add(estimate, lens);
    }
  }
}

bool LensRefinement::seem_right() {
  if (planner_.store().stored_views() == 0) return true;
  LensOptions options;
  options.most_points = std::max(kFewestPointsOfFirstLook, kPointsForFirstLook / planner_.store().stored_views());
  const LensEstimates estimates = planner_.refiner().estimate_lenses(options);
  too_large_ = estimates.too_large;
  if (estimates.undecided()) return false;
  note(estimates);
  return true;
}

// Returns whether the files of all photographs whose lens is to be corrected are there; warns if one is not.
bool LensRefinement::find_originals(const LensEstimates& estimates) {
  try {
    for (const LensEstimate& lens : estimates.lenses) {
      for (const ViewSlot slot : lens.slots) {
        if (lens.significant) require_original(view_named(views_, planner_.store().name_of(slot)));
      }
    }
  } catch (const InputError& error) {
    lost_originals_ = true;
    warn_(std::string(error.what()) + ": lenses stay as they are, because correcting them takes all photographs again");
  }
  return !lost_originals_;
}

bool LensRefinement::correct(std::size_t points) {
  if (lost_originals_ || planner_.store().stored_views() == 0) return false;
  LensOptions options;
  options.most_points = points_of_each(points, planner_.store().stored_views());
  for (const RefinedLens& lens : lenses_) {
    options.least_improvement = std::min(options.least_improvement, least_improvement(lens));
  }
  LensEstimates estimates = planner_.refiner().estimate_lenses(options);
  too_large_ = estimates.too_large;
  for (LensEstimate& estimate : estimates.lenses) {
    const double most = 1 - least_improvement(lens_of(estimates.cameras[estimate.slots.front()]));
    estimate.significant = estimate.significant && estimate.residual.after <= most * estimate.residual.before;
  }
  if (warn_ && !find_originals(estimates)) {
    for (LensEstimate& estimate : estimates.lenses) estimate.significant = false;
  }
  note(estimates);
  if (!estimates.significant()) return false;
  correct_lenses(views_, lenses_);
  planner_.refiner().correct_lenses(
      estimates, [&](std::uint32_t, const std::string& name) { return load_photograph(view_named(views_, name)); });
  return true;
}

void count_views(const Atlas& atlas, std::vector<RefinedLens>& lenses) {
  for (RefinedLens& lens : lenses) {
    lens.views = 0;
    for (ViewSlot slot{0}; slot < atlas.capacity(); ++slot) {
      const std::shared_ptr<const StoredView> view = atlas.view(slot);
      lens.views += view && share_a_lens(view->camera, lens.camera);
    }
  }
}

}  // namespace lumatlas
