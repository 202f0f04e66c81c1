// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/coverage/predicted_loss.h"

#include <algorithm>
#include <cmath>

#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

constexpr double kSlope = 4.4;  // dB where the service falls to a share of 1 / e
// dB, what covers every store that the law was found on (data/results/loss-law.csv). It multiplies the root of the lost
// service, because a small loss takes few views away, and which ones they are matters more than how many; such errors
// grow with the root of their number. The village, which was measured later, would take 1.35.
constexpr double kScatter = 0.9;
// A larger gap leaves nothing.
constexpr double kMostGap = 1 - 1e-9;
// dB; above each of the 15 models that references alone were taken from, most of which lost less than half as much.
constexpr double kReferenceScatter = 6.5;

constexpr Requirement predicted_loss_requires{"predicted loss"};

}  // namespace

CoverageOptions parsimony_coverage(CoverageOptions options) {
  options.lambda = 0.97;  // not 1: a cell that is seen from the side alone is worth something
  options.direction_width = 30;
  return options;
}

double predicted_loss_db(double gap) {
  predicted_loss_requires(!std::isnan(gap), "gap", gap, "a number");
  const double service_lost = -std::log1p(-std::clamp(gap - kGapRounding, 0.0, kMostGap));
  return kSlope * service_lost + kScatter * std::sqrt(service_lost);
}

double predicted_reference_loss_db(double gap) {
  predicted_loss_requires(!std::isnan(gap), "gap", gap, "a number");
  return kReferenceScatter * std::sqrt(std::clamp(gap, 0.0, 1.0));
}

}  // namespace lumatlas
