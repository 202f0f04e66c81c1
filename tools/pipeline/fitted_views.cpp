// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/fitted_views.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "blend/egl_context.h"
#include "tools/pipeline/downscaled_views.h"
#include "tools/pipeline/held_out_loss.h"

namespace lumatlas {

namespace {

// The largest scale found by which all tiles fit, else the least; the views are at it.
double scale_by_which_all_fits(const GpuBudget& budget, double least, Atlas& atlas, ScaledViews& views) {
  constexpr int kMostTries = 5;       // tiles are whole, so that their number is not quite that of the pixels
  constexpr double kMostRoom = 1.05;  // for so much more there may be room
  double fits = least, too_large = 1, scale = 1, room = budget.room_for_tiles(atlas);
  for (int tries = 0; tries < kMostTries && too_large > fits; ++tries) {
    const double next = scale * std::sqrt(room);
    scale = next > fits && next < too_large ? next : (tries == 0 ? least : (fits + too_large) / 2);
    views.scale_to(scale);
    room = budget.room_for_tiles(atlas);
    (room >= 1 ? fits : too_large) = scale;
    if (room >= 1 && room < kMostRoom) break;
  }
  views.scale_to(fits);
  return fits;
}

// Scales between the one by which all fits and 1, each by the same factor.
class FittedScales {
 public:
  static constexpr int kSteps = 3;

  FittedScales(const GpuBudget& budget, double all_fit, Atlas& atlas, ScaledViews& views, HeldOutLoss& measured)
      : budget_(budget), all_fit_(all_fit), atlas_(atlas), views_(views), measured_(measured) {}

  [[nodiscard]] double scale(int step) const { return std::pow(all_fit_, 1 - static_cast<double>(step) / kSteps); }
  [[nodiscard]] MeasuredLoss loss(int step, std::optional<double> bound_db) {
    views_.scale_to(scale(step));
    return measured_.now({{}, 0, std::min(1.0, budget_.room_for_tiles(atlas_))}, bound_db);
  }

 private:
  const GpuBudget& budget_;
  double all_fit_;
  Atlas& atlas_;
  ScaledViews& views_;
  HeldOutLoss& measured_;
};

// The loss has one valley between the two ends, and is found from the lower one. Nothing is looked for where all views,
// smaller, lose next to nothing.
FittedViews of_least_loss(FittedScales& scales) {
  constexpr double kNegligibleDb = 0.1;
  MeasuredLoss least = scales.loss(0, kNegligibleDb);
  if (least.mean_db <= kNegligibleDb) return {scales.scale(0), least, {}};
  int best = 0;
  const auto is_better = [&](int step) {
    const MeasuredLoss loss = scales.loss(step, least.mean_db);
    if (loss.mean_db >= least.mean_db) return false;
    least = loss;
    best = step;
    return true;
  };
  const bool from_above = is_better(FittedScales::kSteps);
  for (int step = 1; step < FittedScales::kSteps; ++step) {
    if (!is_better(from_above ? FittedScales::kSteps - step : step)) break;
  }
  return {scales.scale(best), least, {}};
}

}  // namespace

FittedViews fit_views(const GpuBudget& budget, double least, const Planner& planner, Atlas& atlas,
                      const Visibility& visibility, const ValidityOptions& validity, BuildStage& stage) {
  if (least == 1 || budget.room_for_tiles(atlas) >= 1) return {};
  FittedViews fitted;
  std::optional<HeldOutLoss> measured;
  try {
    measured.emplace(planner, atlas, stage);
  } catch (const GlError& error) {
    fitted.not_measured = error.what();
  }
  ScaledViews views(atlas, visibility, validity);
  fitted.scale = scale_by_which_all_fits(budget, least, atlas, views);
  if (!measured || !measured->can_tell()) return fitted;
  FittedScales scales(budget, fitted.scale, atlas, views, *measured);
  try {
    fitted = of_least_loss(scales);
  } catch (const GlError& error) {
    fitted.not_measured = error.what();
  }
  views.scale_to(fitted.scale);
  return fitted;
}

}  // namespace lumatlas
