// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/refinement/shutter_refinement.h"

#include <cstdint>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/base/errors.h"
#include "mesh/base/median.h"

namespace lumatlas {

namespace {

// Improvement of the residual for motions that have been estimated before: the rest of them improves it less.
constexpr double kLeastFurtherStraightening = 0.003;

}  // namespace

bool ShutterRefinement::has_originals() {
  if (!warn_) return true;
  try {
    for (ViewSlot slot{0}; slot < planner_.store().atlas().capacity(); ++slot) {
      if (planner_.store().atlas().view(slot)) require_original(view_named(views_, planner_.store().name_of(slot)));
    }
  } catch (const InputError& error) {
    warn_(std::string(error.what()) + ": photographs are not straightened, because that takes all photographs again");
    return false;
  }
  return true;
}

// Adds to what was found before, to first order.
void ShutterRefinement::note(const ShutterEstimate& estimate) {
  const double before = refined_.applied ? refined_.estimate.residual.before : estimate.residual.before;
  refined_.estimate = estimate;
  refined_.estimate.residual.before = before;
  refined_.applied = true;
  std::vector<double> moves;
  for (ViewSlot slot{0}; slot < estimate.motions.size(); ++slot) {
    if (estimate.motions[slot] == ShutterMotion{}) continue;
    SceneView& view = view_named(views_, planner_.store().name_of(slot));
    view.motion.turn += estimate.motions[slot].turn;
    view.motion.shift += estimate.motions[slot].shift;
    refined_.motions[view.name] = view.motion;
    moves.push_back(edge_move_px(view.motion, view.camera));
  }
  if (!moves.empty()) refined_.median_px = upper_median(moves);
}

// Views of a panorama have no lines of their own that a shutter reads.
bool ShutterRefinement::has_panoramas() {
  const Atlas& atlas = planner_.store().atlas();
  for (ViewSlot slot{0}; slot < atlas.capacity(); ++slot) {
    if (atlas.view(slot) && view_named(views_, planner_.store().name_of(slot)).panorama) return true;
  }
  return false;
}

bool ShutterRefinement::straighten(std::size_t points) {
  if (has_panoramas()) return false;
  ShutterOptions options;
  options.most_points = points;
  if (refined_.applied) options.least_improvement = kLeastFurtherStraightening;
  const ShutterEstimate estimate = planner_.refiner().estimate_shutters(options);
  if (!refined_.applied) refined_.estimate = estimate;
  if (!estimate.significant || !has_originals()) return false;
  note(estimate);
  planner_.refiner().correct_shutters(
      estimate, [&](std::uint32_t, const std::string& name) { return load_photograph(view_named(views_, name)); });
  return true;
}

}  // namespace lumatlas
