// SPDX-License-Identifier: GPL-3.0-or-later
// Builds of small scenes that store all views, and then give up what a bound on the measured loss allows.
#pragma once

#include "planner/coverage/predicted_loss.h"
#include "tools/pipeline/build_options.h"

namespace lumatlas {

// Up to so much, dB, for texels, whose photographs may be downscaled to half of their sides; views are given up for
// what is left of it.
inline BuildOptions bounded_build(double max_texel_loss_db) {
  BuildOptions options;
  options.max_views.reset();
  options.refine = RefineMode::none;
  options.planner.min_view_gain = 0;
  options.planner.coverage = parsimony_coverage(options.planner.coverage);
  options.planner.coverage.max_references = 64;
  options.planner.max_loss_db = 0;
  options.tiles = {8, 2, 0};
  options.least_scale = 0.5;
  options.texture_px.reset();
  options.bound = Bound::of_loss(max_texel_loss_db, 0);
  return options;
}

}  // namespace lumatlas
