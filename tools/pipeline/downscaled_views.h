// SPDX-License-Identifier: GPL-3.0-or-later
// What a model's photographs give up first where a budget has no room for them, or where a bound on the loss allows
// it: pixels of all alike, before parts of some. Blended from three photographs, and by poses that are never exact, a
// picture shows less detail than each has.
#pragma once

#include "atlas/atlas.h"
#include "mesh/visibility.h"
#include "tools/pipeline/gpu_budget.h"

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
  double scale = 1;    // of a photograph's sides, the share that is kept
  double loss_db = 0;  // measured, see scale_loss.h
};
// As far as the pictures lose at most so much, dB, > 0, by measurement, but not below `least`; in eight steps. Not at
// all where no photograph shows what others show too. Throws GlError where there is no OpenGL to draw them with;
// nothing was changed then.
[[nodiscard]] DownscaledViews downscale_views_within(double max_loss_db, Atlas& atlas, const Visibility& visibility,
                                                     const ValidityOptions& validity, double least);

}  // namespace lumatlas
