// SPDX-License-Identifier: GPL-3.0-or-later
// Options of the planner: the measure and thresholds of its choice, and the bounds of the store.
#pragma once

#include <cstdint>
#include <optional>

#include "atlas/views/validity.h"
#include "planner/coverage/coverage.h"
#include "planner/refinement/refiner.h"

namespace lumatlas {

struct PlannerOptions {
  CoverageOptions coverage;
  ValidityOptions validity;
  RefinementOptions refinement;
  // Delta_scov, >= 0: a view is kept if it raises scov by more than this share of the most that its cells can count.
  // That is their number, or with CoverageOptions::demand the sum of their weights.
  // 0 keeps each view that helps at all; larger keeps fewer views and redoes less. For Metric::paper, by which a cell
  // counts up to fcov_max and not up to 1, 0.1 is right.
  double min_view_gain = 0.001;
  // While the store is full: by more than this share of what its views are worth on average, scov / N; >= 0. At 1, with
  // a min_view_gain of 0, without max_bytes and without outliers, a store by Metric::directions is never worth less
  // than a quarter of the best, whatever the stream (see direction_coverage.h).
  double min_exchange_gain = 0.05;
  // Delta_fcov: by which a full cell's coverage must rise to swap a reference; >= 0. For Metric::paper 0.01 is right.
  double min_reference_gain = 0.001;
  // Number of lowest-ranked views that are considered for replacement; 0: all of them.
  std::uint32_t victims = 0;
  // Bound of the bytes that the stored views take together, see stored_bytes(); 0: the atlas's slots alone bound them.
  std::uint64_t max_bytes = 0;
  // Most PSNR to lose against a store of all offered views, dB, finite, >= 0; needs Metric::directions. While the
  // stream goes on, a view is rejected if the store without it is predicted to lose less than half of this;
  // Pruning::prune() then removes views and references up to all of it (see predicted_loss.h). Without it only the
  // store's capacity bounds the views.
  std::optional<double> max_loss_db;
  // Longer side of the image that cells are counted in, >= 1; never above the photograph's.
  std::uint32_t visibility_px = 160;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const PlannerOptions& options);

}  // namespace lumatlas
