// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/budget/fitted_views.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "blend/gl/egl_context.h"
#include "tools/budget/downscaled_views.h"
#include "tools/budget/held_out_loss.h"

namespace lumatlas {

namespace {

// Scales between the one by which all fits and 1, each by the same factor.
class FittedScales {
 public:
  static constexpr int kSteps = 3;

  FittedScales(const GpuBudget& budget, double all_fit, Atlas& atlas, ScaledViews& views, HeldOutLoss& measured)
      : budget_(budget), all_fit_(all_fit), atlas_(atlas), views_(views), measured_(measured) {}

  [[nodiscard]] double scale(int step) const { return std::pow(all_fit_, 1 - static_cast<double>(step) / kSteps); }
  [[nodiscard]] MeasuredLoss loss(int step) {
    views_.scale_to(scale(step));
    return measured_.now({{}, 0, std::min(1.0, budget_.fitting_share(atlas_))});
  }

 private:
  const GpuBudget& budget_;
  double all_fit_;
  Atlas& atlas_;
  ScaledViews& views_;
  HeldOutLoss& measured_;
};

// 0.005 of structural similarity counts as much as 0.3 dB. PSNR alone prefers blurred pictures: where poses are a
// little wrong, it punishes detail in the wrong place more than none.
double in_all(const MeasuredLoss& loss) {
  return loss.mean_db + 60 * loss.ssim;
}

// The loss has one valley between the two ends, and is found from the lower one. Nothing is looked for where all views,
// smaller, lose next to nothing.
FittedViews of_least_loss(FittedScales& scales) {
  constexpr double kNegligibleDb = 0.1;
  MeasuredLoss least = scales.loss(0);
  if (least.mean_db <= kNegligibleDb) return {scales.scale(0), least, {}};
  int best = 0;
  const auto is_better = [&](int step) {
    const MeasuredLoss loss = scales.loss(step);
    if (in_all(loss) >= in_all(least)) return false;
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
  require_share_of_sides(least);
  const double share = budget.fitting_share(atlas);
  if (least == 1 || share >= 1) return {};
  FittedViews fitted;
  std::optional<HeldOutLoss> measured;
  try {
    measured.emplace(planner, atlas, stage);
  } catch (const GlError& error) {
    fitted.not_measured = error.what();
  }
  ScaledViews views(atlas, visibility, validity);
  fitted.scale = largest_fitting_scale(least, share, [&](double scale) {
    views.scale_to(scale);
    return budget.fitting_share(atlas);
  });
  views.scale_to(fitted.scale);
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

// Tiles are whole, so that fewer pixels need not be fewer of them: the more often the tiles did not fit, the farther
// below what the pixels say the next scale is.
double largest_fitting_scale(double least, double share, const std::function<double(double)>& share_at) {
  constexpr int kMostTries = 6;
  constexpr double kMostShare = 1.05;  // at this share the search ends
  constexpr double kClose = 0.01;
  double fits = 0, too_large = 1, scale = 1, margin = 0.01;
  double most_share = share, scale_of_most = 1;  // if nothing fits, smaller photographs must at least take fewer tiles
  for (int tries = 0; tries < kMostTries && too_large - fits > kClose; ++tries) {
    const double wanted = scale * std::sqrt(share) * (1 - margin);
    const bool between = fits < wanted && wanted < too_large;
    scale = std::max(between ? wanted : (fits + too_large) / 2, least);
    share = share_at(scale);
    if (share >= 1) {
      fits = scale;
      if (share < kMostShare) break;
    } else {
      if (share > most_share) scale_of_most = scale;
      most_share = std::max(most_share, share);
      too_large = scale;
      margin *= 2;
      if (scale == least) break;
    }
  }
  return fits > 0 ? fits : scale_of_most;
}

}  // namespace lumatlas
