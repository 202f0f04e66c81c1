// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/lens_estimate.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mesh/base/requirement.h"
#include "planner/refinement/joint/joint_solver.h"

namespace lumatlas {

namespace {

constexpr std::array<std::uint32_t, 6> kPoseRounds = {1, 0, 0, 0, 0, 0};  // levels above the finest one used
constexpr std::array<std::uint32_t, 18> kRounds = {2, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
constexpr std::array<std::uint32_t, 6> kMoreRounds = {0, 0, 0, 0, 0, 0};  // once a term has come or gone
// See LensEstimate::significant.
constexpr double kLeastDeviations = 5;
constexpr double kLeastCornerPx = 0.5;
constexpr double kFurtherDeviations = 3;  // see LensEstimate::most_corner_px

constexpr Terms kFirstTerms = {true, true, true, true, false, false, false};
// The further terms that are tried, one after the other.
constexpr std::array<Terms, 2> kMoreTerms = {Terms{false, false, false, false, true, false, false},
                                             Terms{false, false, false, false, false, true, true}};

class Estimator {
 public:
  Estimator(const JointInput& input, const LensOptions& options)
      : least_improvement_(options.least_improvement),
        most_operations_(kFactorForLenses * options.most_operations),
        solver_(input, {options.alignment, options.most_points, options.most_operations, options.cancel_check}) {
    for (const std::vector<ViewSlot>& slots : solver_.slots_of_lenses()) lenses_.emplace_back().slots = slots;
    most_improvement_.assign(lenses_.size(), 0);
  }

  [[nodiscard]] LensEstimates estimate() {
    LensEstimates result;
    result.lenses = lenses_;
    result.cameras = solver_.state().cameras;
    result.too_large = solver_.takes_more_than(most_operations_);
    if (result.too_large) return result;
    result.views = solver_.views();
    result.points = solver_.points();
    if (result.views == 0) return result;
    result.unknowns = solver_.unknowns();
    for (int time = 0; time < 2; ++time) {
      solver_.measure_noise();
      solver_.refine(kPoseRounds);
    }
    const std::vector<double> before = solver_.held_out_residuals();
    for (std::size_t lens = 0; lens < lenses_.size(); ++lens) set(lens, kFirstTerms, true);
    solver_.refine(kRounds);
    note_improvement(before);
    for (const Terms& more : kMoreTerms) try_terms(more, before);
    report(before, result);
    return result;
  }

 private:
  void set(std::size_t lens, const Terms& terms, bool estimated) {
    for (std::size_t i = 0; i < terms.size(); ++i) {
      if (terms[i]) solver_.set_estimated(lens, i, estimated);
    }
  }

  // Returns whether a parameter is more than a few deviations away from 0, and the difference can be seen.
  [[nodiscard]] bool is_determined(std::size_t lens, int parameter, const Block& deviation) const {
    Block alone = Block::Zero();
    alone[parameter] = solver_.state().lens_parameters[lens][parameter];
    return std::abs(alone[parameter]) > kLeastDeviations * deviation[parameter] &&
           corner_move_px(correction_of(alone), solver_.camera_of(lens)) > kLeastCornerPx;
  }

  // See LensEstimate::most_corner_px.
  void note_reach(std::size_t lens, int parameter, double deviation) {
    for (const double sign : {-1.0, 1.0}) {
      Block alone = Block::Zero();
      alone[parameter] = solver_.state().lens_parameters[lens][parameter] + sign * kFurtherDeviations * deviation;
      lenses_[lens].most_corner_px =
          std::max(lenses_[lens].most_corner_px, corner_move_px(correction_of(alone), solver_.camera_of(lens)));
    }
  }

  // Estimates further terms too, and gives them up again for the lenses of which the points do not determine any.
  void try_terms(const Terms& more, const std::vector<double>& before) {
    const JointState simpler = solver_.state();
    for (std::size_t lens = 0; lens < lenses_.size(); ++lens) set(lens, more, true);
    solver_.refine(kMoreRounds);
    note_improvement(before);
    const std::vector<Block> variance = solver_.variances();
    std::size_t given_up = 0;
    for (std::size_t lens = 0; lens < lenses_.size(); ++lens) {
      const Block deviation = variance[lens].cwiseSqrt();
      bool determined = false;
      for (int i = 0; i < kBlock; ++i) {
        if (!more[static_cast<std::size_t>(i)]) continue;
        note_reach(lens, i, deviation[i]);
        determined = determined || is_determined(lens, i, deviation);
      }
      if (determined) continue;
      set(lens, more, false);
      ++given_up;
    }
    if (given_up == 0) return;
    if (given_up == lenses_.size()) {
      solver_.set_state(simpler);
    } else {
      solver_.refine(kMoreRounds);
    }
  }

  void note_improvement(const std::vector<double>& before) {
    const std::vector<double> after = solver_.held_out_residuals();
    for (std::size_t lens = 0; lens < lenses_.size(); ++lens) {
      if (!(before[lens] > 0)) continue;
      most_improvement_[lens] = std::max(most_improvement_[lens], 1 - after[lens] / before[lens]);
    }
  }

  void report(const std::vector<double>& before, LensEstimates& result) {
    result.cameras = solver_.state().cameras;
    const std::vector<Block> variance = solver_.variances();
    const std::vector<double> after = solver_.held_out_residuals();
    for (std::size_t lens = 0; lens < lenses_.size(); ++lens) {
      LensEstimate& estimate = result.lenses[lens];
      const auto estimated = [&](int i) { return solver_.terms(lens)[static_cast<std::size_t>(i)]; };
      Block deviation = variance[lens].cwiseSqrt();
      for (int i = 0; i < kBlock; ++i) {
        if (!estimated(i)) deviation[i] = 0;
        if (estimated(i)) note_reach(lens, i, deviation[i]);
      }
      const bool improves = most_improvement_[lens] >= 0.5 * least_improvement_;
      estimate.most_corner_px = improves ? lenses_[lens].most_corner_px : 0;
      estimate.correction = correction_of(solver_.state().lens_parameters[lens]);
      estimate.deviation = {deviation[0], {deviation[1], deviation[2]}, deviation[3], deviation[4], deviation[5],
                            deviation[6]};
      estimate.residual = {before[lens], after[lens]};
      estimate.corner_px = corner_move_px(estimate.correction, solver_.camera_of(lens));
      if (after[lens] > (1 - least_improvement_) * before[lens]) continue;
      for (int i = 0; i < kBlock; ++i) {
        estimate.significant = estimate.significant || (estimated(i) && is_determined(lens, i, deviation));
      }
    }
  }

  double least_improvement_;
  std::size_t most_operations_;
  JointSolver solver_;
  std::vector<LensEstimate> lenses_;  // with their slots, and nothing estimated
  std::vector<double>
      most_improvement_;  // one per lens: share of the residual of the points held out, the most of all fits tried
};

}  // namespace

bool LensEstimates::significant() const {
  return std::any_of(lenses.begin(), lenses.end(), [](const LensEstimate& lens) { return lens.significant; });
}

bool LensEstimates::undecided() const {
  return std::any_of(lenses.begin(), lenses.end(),
                     [](const LensEstimate& lens) { return lens.most_corner_px >= kLeastCornerPx; });
}

LensEstimates estimate_lenses(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
                              std::span<const Camera> given, std::span<const std::vector<SurfaceSample>> samples,
                              const LensOptions& options) {
  constexpr Requirement lens_estimate_requires{"lenses"};
  check_least_improvement(options.least_improvement, lens_estimate_requires);
  const JointInput input{atlas, views, given, samples};
  check(input, options.most_points, lens_estimate_requires);
  return Estimator(input, options).estimate();
}

}  // namespace lumatlas
