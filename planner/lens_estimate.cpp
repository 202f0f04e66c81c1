// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: Triggs et al. 2000, "Bundle adjustment", section 6 (Gauss-Newton); White 1980 for the deviations. Letters as
// in planner/lens_problem.h.
#include "planner/lens_estimate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "mesh/base/median.h"
#include "mesh/base/requirement.h"
#include "planner/lens_equations.h"
#include "planner/lens_problem.h"
#include "planner/normal_equations.h"
#include "planner/photometry.h"

namespace lumatlas {

namespace {

constexpr std::array<std::uint32_t, 6> kPoseRounds = {1, 0, 0, 0, 0, 0};  // levels above the finest one used
constexpr std::array<std::uint32_t, 18> kRounds = {2, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
constexpr double kRidge = 1e-7;  // of the normal matrix' mean diagonal: for views that nothing else holds
constexpr double kRests = 2e-4;  // a round that changes the residual by less is the last
constexpr std::array<std::uint32_t, 6> kMoreRounds = {0, 0, 0, 0, 0, 0};  // once a term has come or gone
constexpr double kFixed = 1e6;  // times the normal matrix' trace: for parameters that stay
// See LensEstimate::deviation and significant.
constexpr double kCountedTwice = 2;
constexpr double kChannels = 3;
constexpr double kLeastDeviations = 5;
constexpr double kLeastCornerPx = 0.5;
constexpr double kFurtherDeviations = 3;  // see LensEstimate::most_corner_px

// Which of a lens's parameters are estimated; the others are 0.
using Terms = std::array<bool, kBlock>;
constexpr Terms kFirstTerms = {true, true, true, true, false, false, false};
// What is tried then, one after the other.
constexpr std::array<Terms, 2> kMoreTerms = {Terms{false, false, false, false, true, false, false},
                                             Terms{false, false, false, false, false, true, true}};

// Weak knowledge about lenses: standard deviations.
const Block kPrior = (Block() << 0.1, 0.05, 0.05, 0.1, 0.1, 0.01, 0.01).finished();

class Estimator {
 public:
  Estimator(const Atlas& atlas, std::span<const std::optional<ComparedView>> views, std::span<const Camera> given,
            std::span<const std::vector<SurfaceSample>> samples, const LensOptions& options)
      : views_(views),
        given_(given),
        options_(options),
        problem_(atlas, views, samples, found_lenses(), options.most_points, options.interruption_point),
        parts_(problem_.parts()) {
    blocks_ = lenses_.size();
    block_of_.assign(views.size(), 0);
    for (std::size_t slot = 0; slot < views.size(); ++slot) {
      if (views[slot]) block_of_[slot] = blocks_++;
    }
    state_.shared.assign(lenses_.size(), Block::Zero());
    state_.gain.assign(views.size(), 1);
    terms_.assign(lenses_.size(), kFirstTerms);
  }

  [[nodiscard]] LensEstimates estimate() {
    LensEstimates result;
    for (const LensPart& part : parts_) {
      result.views += !part.points.empty();
      result.points += part.points.size();
    }
    result.lenses = lenses_;
    result.cameras = state_.cameras;
    if (result.views == 0) return result;
    result.unknowns = kBlock * blocks_;
    noise_ = noise();
    refine(kPoseRounds, false);
    noise_ = noise();
    refine(kPoseRounds, false);
    const std::vector<double> before = held_out_residuals();
    most_improvement_.assign(lenses_.size(), 0);
    refine(kRounds, true);
    note_improvement(before);
    for (const Terms& more : kMoreTerms) try_terms(more, before);
    report(before, result);
    return result;
  }

 private:
  // By slot, from the cameras of the stored views.
  std::vector<std::size_t> found_lenses() {
    state_.cameras.resize(views_.size());
    std::vector<std::size_t> lens_of(views_.size(), 0);
    for (std::uint32_t slot = 0; slot < views_.size(); ++slot) {
      if (!views_[slot]) continue;
      const Camera& camera = views_[slot]->camera;
      state_.cameras[slot] = camera;
      const auto same = std::find_if(lenses_.begin(), lenses_.end(), [&](const LensEstimate& lens) {
        return share_a_lens(state_.cameras[lens.slots.front()], camera);
      });
      lens_of[slot] = static_cast<std::size_t>(same - lenses_.begin());
      if (same == lenses_.end()) lenses_.emplace_back();
      lenses_[lens_of[slot]].slots.push_back(slot);
    }
    return lens_of;
  }

  [[nodiscard]] std::vector<Linearised> linearise(const LensState& state,
                                                  std::vector<ComparedPoint> LensPart::*points = &LensPart::points,
                                                  std::uint32_t coarser = 0, bool robust = true) const {
    return problem_.linearise(state, points, coarser, noise_, robust);
  }

  [[nodiscard]] static Eigen::Index lens_column(std::size_t lens) { return static_cast<Eigen::Index>(kBlock * lens); }
  [[nodiscard]] Eigen::Index column(std::size_t slot) const {
    return static_cast<Eigen::Index>(kBlock * block_of_[slot]);
  }

  // What is not estimated has the prior alone, and so stays 0.
  [[nodiscard]] LensEquations normal_equations(const LensState& state, const std::vector<Linearised>& all) const {
    std::vector<Block> estimated;
    for (const Terms& terms : terms_) {
      estimated.push_back(
          Block::NullaryExpr([&](Eigen::Index i) { return terms[static_cast<std::size_t>(i)] ? 1.0 : 0.0; }));
    }
    LensEquations normal = lens_equations(problem_, state, all, estimated, block_of_, options_.interruption_point);
    const double ridge = kRidge * (normal.H.trace() / static_cast<double>(kBlock * blocks_) + 1);
    normal.H.diagonal().array() += ridge;
    const Block prior = kPrior.array().square().inverse();
    for (std::size_t lens = 0; lens < lenses_.size(); ++lens) {
      normal.H.diagonal().segment<kBlock>(lens_column(lens)) += prior;
      normal.g.segment<kBlock>(lens_column(lens)) += prior.cwiseProduct(state.shared[lens]);
    }
    add_pulls(state, normal);
    return normal;
  }

  // As when views are aligned one by one. Without it, a change of the focal length for which all views move along their
  // axes would cost nothing, and whoever draws from the given poses would see the loss.
  void add_pulls(const LensState& state, LensEquations& normal) const {
    for (std::uint32_t slot = 0; slot < parts_.size(); ++slot) {
      if (!views_[slot]) continue;
      const double pull = pose_pull(options_.alignment, state.cameras[slot], parts_[slot].points.size());
      const auto [turn, shift] = motion_between(given_[slot], state.cameras[slot]);
      const double depth = parts_[slot].depth;
      Eigen::Matrix<double, kPose, 1> pose;
      pose << turn.x, turn.y, turn.z, shift.x / depth, shift.y / depth, shift.z / depth;
      normal.H.diagonal().segment<kPose>(column(slot)).array() += pull * pull;
      normal.g.segment<kPose>(column(slot)) += pull * pull * pose;
    }
  }

  // Without `shared` the lenses stay as they are.
  [[nodiscard]] LensState stepped(LensState state, const std::vector<Linearised>& all, bool shared) const {
    LensEquations normal = normal_equations(state, all);
    const auto first_pose = static_cast<Eigen::Index>(kBlock * lenses_.size());
    if (!shared) normal.H.diagonal().head(first_pose).array() += kFixed * normal.H.trace();
    const Eigen::VectorXd step = -solve_positive_definite(normal.H, normal.g, options_.interruption_point);
    for (std::uint32_t slot = 0; slot < parts_.size(); ++slot) {
      if (!views_[slot]) continue;
      const Block dp = step.segment<kBlock>(column(slot));
      const double depth = parts_[slot].depth;
      state.cameras[slot] = moved(state.cameras[slot], {dp[0], dp[1], dp[2]}, depth * glm::dvec3(dp[3], dp[4], dp[5]));
      state.gain[slot] *= std::exp(dp[6]);
    }
    for (std::size_t lens = 0; shared && lens < lenses_.size(); ++lens) {
      for (int i = 0; i < kBlock; ++i) {
        if (terms_[lens][static_cast<std::size_t>(i)]) state.shared[lens][i] += step[lens_column(lens) + i];
      }
    }
    return state;
  }

  static double root_mean_square(const std::vector<Linearised>& all) {
    double sum = 0;
    double rows = 0;
    for (const Linearised& linear : all) {
      sum += linear.r.squaredNorm();
      rows += static_cast<double>(linear.r.size());
    }
    return std::sqrt(sum / rows);
  }

  [[nodiscard]] double noise() {
    noise_ = 1;
    std::vector<double> differences;
    for (const Linearised& linear : linearise(state_, &LensPart::points, 0, false)) {
      for (const double r : linear.r) differences.push_back(std::abs(r));
    }
    return std::max(kSmallestNoise, kDeviationOfMedian * upper_median(differences));
  }

  // Leaves the best state of those at the finest level, the present one among them.
  template <std::size_t Rounds>
  void refine(const std::array<std::uint32_t, Rounds>& rounds, bool shared) {
    LensState state = state_;
    std::vector<Linearised> finest = linearise(state);
    residual_ = noise_ * root_mean_square(finest);
    for (const std::uint32_t coarser : rounds) {
      if (coarser > 0) {
        state = stepped(std::move(state), linearise(state, &LensPart::points, coarser), shared);
        finest.clear();
        continue;
      }
      if (finest.empty()) finest = linearise(state);
      state = stepped(std::move(state), finest, shared);
      finest = linearise(state);
      const double residual = noise_ * root_mean_square(finest);
      const bool rests = residual > (1 - kRests) * residual_ && residual < (1 + kRests) * residual_;
      if (residual < residual_) {
        residual_ = residual;
        state_ = state;
      }
      if (rests) return;
    }
  }

  // Variances of q by lens: see LensEstimate::deviation.
  [[nodiscard]] std::vector<Block> variances() const {
    const std::vector<Linearised> all = linearise(state_);
    LensEquations normal = normal_equations(state_, all);
    // The columns of the inverse that belong to q: all other parameters are marginalised.
    const auto columns = static_cast<Eigen::Index>(kBlock * lenses_.size());
    const Eigen::MatrixXd inverse = solve_positive_definite(
        normal.H, Eigen::MatrixXd::Identity(normal.H.rows(), columns), options_.interruption_point);
    Eigen::VectorXd observed = Eigen::VectorXd::Zero(columns);
    for (const ViewGradient& gradient : normal.of_views) {
      Eigen::VectorXd moved = Eigen::VectorXd::Zero(columns);
      for (std::size_t i = 0; i < gradient.blocks.size(); ++i) {
        moved += inverse.middleRows<kBlock>(static_cast<Eigen::Index>(kBlock * gradient.blocks[i])).transpose() *
                 gradient.values[i];
      }
      observed += moved.cwiseAbs2();
    }
    const double mean_square = std::pow(root_mean_square(all), 2);
    std::vector<Block> result;
    for (std::size_t lens = 0; lens < lenses_.size(); ++lens) {
      const Eigen::Index first = lens_column(lens);
      const Block modelled = kChannels * mean_square * inverse.block<kBlock, kBlock>(first, first).diagonal().eval();
      result.push_back(kCountedTwice * modelled.cwiseMax(observed.segment<kBlock>(first)));
    }
    return result;
  }

  // Whether a parameter is more than a few deviations away from 0, and that can be seen.
  [[nodiscard]] bool is_determined(std::size_t lens, int parameter, const Block& deviation) const {
    Block alone = Block::Zero();
    alone[parameter] = state_.shared[lens][parameter];
    return std::abs(alone[parameter]) > kLeastDeviations * deviation[parameter] &&
           corner_move_px(correction_of(alone), camera_of(lens)) > kLeastCornerPx;
  }

  // See LensEstimate::most_corner_px.
  void note_reach(std::size_t lens, int parameter, double deviation) {
    for (const double sign : {-1.0, 1.0}) {
      Block alone = Block::Zero();
      alone[parameter] = state_.shared[lens][parameter] + sign * kFurtherDeviations * deviation;
      lenses_[lens].most_corner_px =
          std::max(lenses_[lens].most_corner_px, corner_move_px(correction_of(alone), camera_of(lens)));
    }
  }

  [[nodiscard]] const Camera& camera_of(std::size_t lens) const { return state_.cameras[lenses_[lens].slots.front()]; }

  // Estimates further terms too, and gives them up again for the lenses of which the points do not determine any.
  void try_terms(const Terms& more, const std::vector<double>& before) {
    const auto set = [&](std::size_t lens, bool estimated) {
      for (int i = 0; i < kBlock; ++i) {
        const auto term = static_cast<std::size_t>(i);
        if (!more[term]) continue;
        terms_[lens][term] = estimated;
        if (!estimated) state_.shared[lens][i] = 0;
      }
    };
    const LensState simpler = state_;
    for (std::size_t lens = 0; lens < lenses_.size(); ++lens) set(lens, true);
    refine(kMoreRounds, true);
    note_improvement(before);
    const std::vector<Block> variance = variances();
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
      set(lens, false);
      ++given_up;
    }
    if (given_up == 0) return;
    if (given_up == lenses_.size()) {
      state_ = simpler;
    } else {
      refine(kMoreRounds, true);
    }
  }

  // By lens, of the points that nothing was fitted to.
  [[nodiscard]] std::vector<double> held_out_residuals() const {
    const std::vector<Linearised> all = linearise(state_, &LensPart::held_out);
    std::vector<double> of_lenses;
    for (const LensEstimate& lens : lenses_) {
      double sum = 0, rows = 0;
      for (const std::uint32_t slot : lens.slots) {
        sum += all[slot].r.squaredNorm();
        rows += static_cast<double>(all[slot].r.size());
      }
      of_lenses.push_back(rows > 0 ? noise_ * std::sqrt(sum / rows) : 0);
    }
    return of_lenses;
  }

  void note_improvement(const std::vector<double>& before) {
    const std::vector<double> after = held_out_residuals();
    for (std::size_t lens = 0; lens < lenses_.size(); ++lens) {
      if (!(before[lens] > 0)) continue;
      most_improvement_[lens] = std::max(most_improvement_[lens], 1 - after[lens] / before[lens]);
    }
  }

  void report(const std::vector<double>& before, LensEstimates& result) {
    result.cameras = state_.cameras;
    const std::vector<Block> variance = variances();
    const std::vector<double> after = held_out_residuals();
    for (std::size_t lens = 0; lens < lenses_.size(); ++lens) {
      LensEstimate& estimate = result.lenses[lens];
      const auto estimated = [&](int i) { return terms_[lens][static_cast<std::size_t>(i)]; };
      Block deviation = variance[lens].cwiseSqrt();
      for (int i = 0; i < kBlock; ++i) {
        if (!estimated(i)) deviation[i] = 0;
        if (estimated(i)) note_reach(lens, i, deviation[i]);
      }
      const bool improves = most_improvement_[lens] >= 0.5 * options_.least_improvement;
      estimate.most_corner_px = improves ? lenses_[lens].most_corner_px : 0;
      estimate.correction = correction_of(state_.shared[lens]);
      estimate.deviation = {deviation[0], {deviation[1], deviation[2]}, deviation[3], deviation[4], deviation[5],
                            deviation[6]};
      estimate.residual = {before[lens], after[lens]};
      estimate.corner_px = corner_move_px(estimate.correction, camera_of(lens));
      if (after[lens] > (1 - options_.least_improvement) * before[lens]) continue;
      for (int i = 0; i < kBlock; ++i) {
        estimate.significant = estimate.significant || (estimated(i) && is_determined(lens, i, deviation));
      }
    }
  }

  std::span<const std::optional<ComparedView>> views_;
  std::span<const Camera> given_;
  LensOptions options_;
  std::vector<LensEstimate> lenses_;  // with their slots, and nothing estimated
  LensState state_;
  LensProblem problem_;
  const std::vector<LensPart>& parts_;
  std::vector<Terms> terms_;           // by lens
  std::vector<std::size_t> block_of_;  // by slot: of the whole problem, where there is a view
  std::size_t blocks_ = 0;
  double noise_ = 1;                      // of the differences, sRGB
  double residual_ = 0;                   // of state_
  std::vector<double> most_improvement_;  // by lens: share of the residual of the points held out, of all fits tried
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
  lens_estimate_requires(options.most_points >= 1, "most_points", 0, "at least 1");
  lens_estimate_requires(options.least_improvement > 0 && options.least_improvement < 1, "least_improvement",
                         options.least_improvement, "in (0, 1)");
  lens_estimate_requires.has_size(views.size(), atlas.capacity(), "views", "the atlas's capacity");
  lens_estimate_requires.has_size(given.size(), atlas.capacity(), "given", "the atlas's capacity");
  lens_estimate_requires.has_size(samples.size(), atlas.capacity(), "samples", "the atlas's capacity");
  const std::size_t faces = atlas.surface().cells.cell_of_face.size();
  for (const std::vector<SurfaceSample>& of_view : samples) {
    for (const SurfaceSample& sample : of_view)
      lens_estimate_requires.is_below(sample.face, faces, "a sample's face", "the faces");
  }
  return Estimator(atlas, views, given, samples, options).estimate();
}

}  // namespace lumatlas
