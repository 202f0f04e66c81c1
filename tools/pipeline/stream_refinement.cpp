// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/stream_refinement.h"

namespace lumatlas {

namespace {

// Of all stored views together: half of what is taken once the stream has ended.
constexpr std::size_t kPointsInStream = 30000;

}  // namespace

void StreamRefinement::before_offer(SceneView& view) const {
  for (const RefinedLens& lens : lenses_) {
    if (lens.applied && share_a_lens(view.camera, lens.camera)) view.correction = lens.estimate.correction;
  }
}

void StreamRefinement::after_offer() {
  const std::uint32_t stored = planner_.stored_views();
  const bool wanted = options_.refine == RefineMode::all && options_.planner.refinement.any();
  if (!wanted || stored < next_polish_) return;
  next_polish_ = stored + stored / 2;
  if (planner_.at_rest() && (!options_.refine_lenses || refinement_.seem_right())) return;
  (void)planner_.polish();
  if (!options_.refine_lenses || stored < next_look_) return;
  if (!refinement_.correct(kPointsInStream)) next_look_ = 2 * stored;
}

}  // namespace lumatlas
