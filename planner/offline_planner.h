// SPDX-License-Identifier: GPL-3.0-or-later
// Chooses views among all at once, to compare the online planner with it (Erat et al. 2019, section 4.9). It uses the
// online planner's measure. Greedy selection with lazy evaluation (Minoux 1978), then exchanges of
// one view against another until none raises scov.
//
// For Metric::directions, which is monotone submodular, lazy evaluation chooses what plain greedy selection would, with
// a value of at least 1 - 1/e of that of the best choice of as many views (Nemhauser, Wolsey, Fisher 1978). For
// Metric::paper neither holds, because the gain of a view can grow while others come and depends on the order of
// arrival. A view is then taken if its gain, evaluated anew, is no less than the last evaluated gains of the others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/cancel_check.h"
#include "planner/coverage/coverage.h"

namespace lumatlas {

struct OfflineOptions {
  CoverageOptions coverage;
  double min_reference_gain = 0.001;  // see PlannerOptions::min_reference_gain, >= 0
  // Exchange passes over the views that are not chosen; the last is the first that exchanges nothing. 0: none.
  std::uint32_t max_passes = 20;
  CancelCheck cancel_check = {};  // called at each evaluation of a view
};

struct OfflineChoice {
  std::vector<std::uint32_t> views;    // indices, ascending
  double greedy_coverage = 0;          // scov before the exchanges, in cells
  double summed_coverage = 0;          // scov, in cells; never less than greedy_coverage
  std::size_t evaluations = 0;         // evaluations of a view's gain, before the exchanges
  std::vector<std::size_t> exchanges;  // in each pass
};

// Returns at most `count` views, >= 1 (std::invalid_argument); fewer only if there are no more, or if no other view has
// a gain. `views`: the cells that each view sees, as Planner::parts_of() returns them. The first of equal views is
// chosen. Throws std::invalid_argument for bad options.
[[nodiscard]] OfflineChoice plan_offline(const Surface& surface, std::span<const std::vector<CellPart>> views,
                                         std::uint32_t count, const OfflineOptions& options);

}  // namespace lumatlas
