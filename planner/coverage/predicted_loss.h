// SPDX-License-Identifier: GPL-3.0-or-later
// Predicts from coverage how many decibels a store loses against a store of all offered views.
//
//   loss = slope * x + scatter * sqrt(x),   x = ln(1 / (1 - gap))
//
// with the gap of offered_coverage.h. Each further share of the remaining coverage costs the same, and no bound allows
// an empty store. The second term is a margin: a store may lose more than the mean of its kind. Both constants are the
// same for all scenes; the stores that they were fitted to are in data/results/loss-law.csv and reference-loss-law.csv.
// It is for the coverage of parsimony_coverage(), and for where nothing can be measured: while the stream runs, and
// without OpenGL.
#pragma once

#include "planner/coverage/coverage.h"

namespace lumatlas {

// The measure that the law is for: directions count by how near a view is to them, within 30 degrees.
[[nodiscard]] CoverageOptions parsimony_coverage(CoverageOptions options);

// Qualities have single precision, so that a gap summed from them may be off by this much.
constexpr double kGapRounding = 1e-7;

// Returns the loss of fitted PSNR, dB, finite: 0 where the gap, in [0, 1], is 0, and more the larger it is. A gap that
// rounding has put beyond either end counts as that end. NaN is refused (std::invalid_argument), here and below.
[[nodiscard]] double predicted_loss_db(double gap);

// Returns the further loss when cells refer to fewer of the stored views, dB of fitted PSNR: 6.5 dB * sqrt(gap), with
// the gap of their service in [0, 1], see direction_coverage.h.
[[nodiscard]] double predicted_reference_loss_db(double gap);

}  // namespace lumatlas
