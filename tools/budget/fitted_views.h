// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs within a budget of bytes: all of them smaller, or parts of them, or both, whichever the pictures lose
// least by. Where poses are a little wrong, pictures show less detail than photographs, and miss none of it; where they
// are exact, parts of sharp photographs show more than the whole of blurred ones.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "atlas/atlas.h"
#include "mesh/visibility/visibility.h"
#include "planner/planner.h"
#include "tools/budget/build_progress.h"
#include "tools/budget/gpu_budget.h"
#include "tools/budget/measured_loss.h"

namespace lumatlas {

struct FittedViews {
  double scale = 1;                  // scale of a photograph's sides
  std::optional<MeasuredLoss> loss;  // none: nothing had to go, no view may be smaller, or the loss cannot be measured
  std::string not_measured;          // why, where OpenGL failed
};
// Downscales all views that `planner` has stored by one factor, at least `least`, in (0, 1] (std::invalid_argument).
// The factor is that of largest_fitting_scale() if pictures lose next to no PSNR by it, or if the loss cannot be
// measured (see HeldOutLoss). Otherwise it is the one with the least loss, in PSNR and structural similarity, once
// GpuBudget::fitted_snapshot() has left out the tiles that do not fit. A factor of 1 changes nothing. The atlas must
// not change otherwise meanwhile.
[[nodiscard]] FittedViews fit_views(const GpuBudget& budget, double least, const Planner& planner, Atlas& atlas,
                                    const Visibility& visibility, const ValidityOptions& validity, BuildStage& stage);

// Returns nearly the largest scale in [`least`, 1) at which all tiles fit: share_at(scale) is 1 or more. It is the
// share of the tiles that fit, falls in steps, roughly with the scale's square, and is `share`, in (0, 1), at 1. Calls
// it at most six times. If no call gave 1 or more, returns the largest scale with the largest share, 1 included.
[[nodiscard]] double largest_fitting_scale(double least, double share, const std::function<double(double)>& share_at);

}  // namespace lumatlas
