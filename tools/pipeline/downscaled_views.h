// SPDX-License-Identifier: GPL-3.0-or-later
// What a model's photographs give up first where a budget has no room for them, or where a bound on the loss allows
// it: pixels of all alike, before parts of some. Blended from three photographs, and by poses that are never exact, a
// picture shows less detail than each has.
#pragma once

#include "atlas/atlas.h"
#include "mesh/visibility.h"
#include "tools/pipeline/gpu_budget.h"
#include "tools/pipeline/held_out_loss.h"

namespace lumatlas {

// Downscales all stored views by one factor, so that the tiles that their references need fit into the budget, but not
// below `least`, in (0, 1], of a photograph's sides (std::invalid_argument); the rest is for
// GpuBudget::fitted_snapshot(). Returns that factor: 1 where all fits as it is, and nothing was changed. Nobody else
// may change the atlas meanwhile.
[[nodiscard]] double downscale_views(Atlas& atlas, const GpuBudget& budget, const Visibility& visibility,
                                     const ValidityOptions& validity, double least);

// How the depth edges of views are masked that are downscaled by `scale`, (0, 1] (std::invalid_argument): as wide on
// the surface as before, rounded up to a pixel.
[[nodiscard]] ValidityOptions validity_at_scale(const ValidityOptions& validity, double scale);

struct DownscaledViews {
  double scale = 1;   // of a photograph's sides, the share that is kept
  MeasuredLoss loss;  // only as exactly as it took to decide; 0 at full resolution, whatever the references and texels
};
// As far as the pictures lose at most so much, dB, by measurement, with references given up too (see HeldOutLoss), but
// not below `least`, in (0, 1] (std::invalid_argument); in eight steps. `measured` was made of the views as they are
// now, and must be able to tell. Throws GlError as it does; nothing was changed then.
[[nodiscard]] DownscaledViews downscale_views_within(double max_loss_db, double reference_loss_db, Atlas& atlas,
                                                     HeldOutLoss& measured, const Visibility& visibility,
                                                     const ValidityOptions& validity, double least);

}  // namespace lumatlas
