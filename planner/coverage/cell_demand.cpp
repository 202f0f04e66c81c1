// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/coverage/cell_demand.h"

#include <cmath>
#include <stdexcept>

#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

// Sums are integers, so that what was added can be removed exactly: shares of a picture in 24 bits, logarithms of
// distance in steps of 1/256 octave. A million views of anything within 2^+-64 units fit into 63 bits.
constexpr double kPicture = 1 << 24;
constexpr double kOctave = 1 << 8;
constexpr double kStepsPerOctave = 8;

constexpr Requirement cell_demand_requires{"demand"};

}  // namespace

void CellDemand::count(const Contribution& part, int sign) {
  check(part);
  if (!(part.distance > 0)) return;
  if (views_ + sign < 0) throw std::invalid_argument("demand: a part is removed that was not added");
  const std::int64_t share = std::llround(part.picture_share * kPicture);
  views_ += sign;
  shares_ += sign * share;
  log_distances_ += sign * share * std::llround(std::log2(part.distance) * kOctave);
}

double CellDemand::weight(double prior) const {
  cell_demand_requires(std::isfinite(prior) && prior >= 0, "prior", prior, "finite and not negative");
  return views_ > 0 ? static_cast<double>(shares_) / kPicture / (static_cast<double>(views_) + prior) : 0;
}

double CellDemand::ideal_distance() const {
  if (shares_ <= 0) return 0;
  const double octaves = static_cast<double>(log_distances_) / static_cast<double>(shares_) / kOctave;
  return std::exp2(std::round(octaves * kStepsPerOctave) / kStepsPerOctave);
}

}  // namespace lumatlas
