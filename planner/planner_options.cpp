// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/planner_options.h"

#include <cmath>

#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

constexpr Requirement planner_requires{"planner"};

}  // namespace

void check(const PlannerOptions& options) {
  check(options.coverage);
  check(options.validity);
  check(options.refinement);
  planner_requires(std::isfinite(options.min_view_gain) && options.min_view_gain >= 0, "min_view_gain",
                   options.min_view_gain, "finite and not negative");
  planner_requires(std::isfinite(options.min_reference_gain) && options.min_reference_gain >= 0, "min_reference_gain",
                   options.min_reference_gain, "finite and not negative");
  planner_requires(std::isfinite(options.min_exchange_gain) && options.min_exchange_gain >= 0, "min_exchange_gain",
                   options.min_exchange_gain, "finite and not negative");
  if (options.max_loss_db) {
    planner_requires(std::isfinite(*options.max_loss_db) && *options.max_loss_db >= 0, "max_loss_db",
                     *options.max_loss_db, "finite and not negative");
    planner_requires(options.coverage.metric == CoverageOptions::Metric::directions, "max_loss_db",
                     *options.max_loss_db, "none with Metric::paper, for which there is no law");
  }
  planner_requires(options.visibility_px >= 1, "visibility_px", options.visibility_px, "at least 1");
}

}  // namespace lumatlas
