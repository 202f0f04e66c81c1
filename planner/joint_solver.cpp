// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/joint_solver.h"

#include <algorithm>
#include <cmath>

#include "mesh/base/median.h"
#include "planner/normal_equations.h"
#include "planner/photometry.h"

namespace lumatlas {

namespace {

constexpr double kRidge = 1e-7;  // of the normal matrix' mean diagonal: for views that nothing else holds
constexpr double kRests = 2e-4;  // a round that changes the residual by less is the last
constexpr double kFixed = 1e6;   // times the normal matrix' trace: for views that take no part
// See LensEstimate::deviation.
constexpr double kCountedTwice = 2;
constexpr double kChannels = 3;

// Weak knowledge about lenses: standard deviations.
const Block kPrior = (Block() << 0.1, 0.05, 0.05, 0.1, 0.1, 0.01, 0.01).finished();

Eigen::Index lens_column(std::size_t lens) {
  return static_cast<Eigen::Index>(kBlock * lens);
}

// Squares of residuals, and how many.
struct Squares {
  double sum = 0, rows = 0;

  void add(const Linearised& linear) {
    sum += linear.r.squaredNorm();
    rows += static_cast<double>(linear.r.size());
  }
  [[nodiscard]] double root_mean() const { return rows > 0 ? std::sqrt(sum / rows) : 0; }
};

Squares squares_of(const std::vector<Linearised>& all) {
  Squares squares;
  for (const Linearised& linear : all) squares.add(linear);
  return squares;
}

}  // namespace

void check(const JointInput& input, const Requirement& requires_) {
  const std::size_t slots = input.atlas.capacity();
  requires_.has_size(input.views.size(), slots, "views", "the atlas's capacity");
  requires_.has_size(input.given.size(), slots, "given", "the atlas's capacity");
  requires_.has_size(input.samples.size(), slots, "samples", "the atlas's capacity");
  const std::size_t faces = input.atlas.surface()->cells.cell_of_face.size();
  for (const std::vector<SurfaceSample>& of_view : input.samples) {
    for (const SurfaceSample& sample : of_view) requires_.is_below(sample.face, faces, "a sample's face", "the faces");
  }
}

JointSolver::JointSolver(const JointInput& input, const JointOptions& options)
    : views_(input.views),
      given_(input.given),
      options_(options),
      problem_(input.atlas, input.views, input.samples, found_lenses(), options.most_points,
               options.interruption_point),
      parts_(problem_.parts()) {
  blocks_ = slots_of_lenses_.size();
  block_of_.assign(views_.size(), 0);
  for (std::size_t slot = 0; slot < views_.size(); ++slot) {
    if (views_[slot]) block_of_[slot] = blocks_++;
  }
  state_.shared.assign(slots_of_lenses_.size(), Block::Zero());
  state_.gain.assign(views_.size(), 1);
  terms_.assign(slots_of_lenses_.size(), Terms{});
}

// By slot, from the cameras of the stored views, which the state gets.
std::vector<std::size_t> JointSolver::found_lenses() {
  state_.cameras.resize(views_.size());
  std::vector<std::size_t> lens_of(views_.size(), 0);
  for (std::uint32_t slot = 0; slot < views_.size(); ++slot) {
    if (!views_[slot]) continue;
    const Camera& camera = views_[slot]->camera;
    state_.cameras[slot] = camera;
    const auto same = std::find_if(
        slots_of_lenses_.begin(), slots_of_lenses_.end(),
        [&](const std::vector<std::uint32_t>& slots) { return share_a_lens(state_.cameras[slots.front()], camera); });
    lens_of[slot] = static_cast<std::size_t>(same - slots_of_lenses_.begin());
    if (same == slots_of_lenses_.end()) slots_of_lenses_.emplace_back();
    slots_of_lenses_[lens_of[slot]].push_back(slot);
  }
  return lens_of;
}

std::size_t JointSolver::views() const {
  return static_cast<std::size_t>(
      std::count_if(parts_.begin(), parts_.end(), [](const ViewPart& part) { return !part.points.empty(); }));
}

std::size_t JointSolver::points() const {
  std::size_t points = 0;
  for (const ViewPart& part : parts_) points += part.points.size();
  return points;
}

void JointSolver::set_estimated(std::size_t lens, std::size_t parameter, bool estimated) {
  terms_[lens][parameter] = estimated;
  if (!estimated) state_.shared[lens][static_cast<Eigen::Index>(parameter)] = 0;
}

std::vector<Linearised> JointSolver::linearise(const JointState& state, std::vector<ComparedPoint> ViewPart::*points,
                                               std::uint32_t coarser, bool robust) const {
  return problem_.linearise(state, points, coarser, noise_, robust);
}

Eigen::Index JointSolver::column(std::size_t slot) const {
  return static_cast<Eigen::Index>(kBlock * block_of_[slot]);
}

// What is not estimated has the prior alone, and so stays 0.
JointEquations JointSolver::normal_equations(const JointState& state, const std::vector<Linearised>& all) const {
  std::vector<Block> estimated;
  for (const Terms& terms : terms_) {
    estimated.push_back(
        Block::NullaryExpr([&](Eigen::Index i) { return terms[static_cast<std::size_t>(i)] ? 1.0 : 0.0; }));
  }
  JointEquations normal = joint_equations(problem_, state, all, estimated, block_of_, options_.interruption_point);
  const double ridge = kRidge * (normal.H.trace() / static_cast<double>(kBlock * blocks_) + 1);
  normal.H.diagonal().array() += ridge;
  const Block prior = kPrior.array().square().inverse();
  for (std::size_t lens = 0; lens < slots_of_lenses_.size(); ++lens) {
    normal.H.diagonal().segment<kBlock>(lens_column(lens)) += prior;
    normal.g.segment<kBlock>(lens_column(lens)) += prior.cwiseProduct(state.shared[lens]);
  }
  add_pulls(state, normal);
  return normal;
}

// As when views are aligned one by one. Without it, a change of the focal length for which all views move along their
// axes would cost nothing, and whoever draws from the given poses would see the loss.
void JointSolver::add_pulls(const JointState& state, JointEquations& normal) const {
  const double fixed = kFixed * normal.H.trace();
  for (std::uint32_t slot = 0; slot < parts_.size(); ++slot) {
    if (!views_[slot]) continue;
    // Else it would follow those that are compared with it.
    if (parts_[slot].points.empty()) normal.H.diagonal().segment<kBlock>(column(slot)).array() += fixed;
    const double pull = pose_pull(options_.alignment, state.cameras[slot], parts_[slot].points.size());
    const auto [turn, shift] = motion_between(given_[slot], state.cameras[slot]);
    const double depth = parts_[slot].depth;
    Eigen::Matrix<double, kPose, 1> pose;
    pose << turn.x, turn.y, turn.z, shift.x / depth, shift.y / depth, shift.z / depth;
    normal.H.diagonal().segment<kPose>(column(slot)).array() += pull * pull;
    normal.g.segment<kPose>(column(slot)) += pull * pull * pose;
  }
}

JointState JointSolver::stepped(const JointState& from, const std::vector<Linearised>& all) const {
  JointState state = from;
  JointEquations normal = normal_equations(from, all);
  const Eigen::VectorXd step = -solve_positive_definite(normal.H, normal.g, options_.interruption_point);
  for (std::uint32_t slot = 0; slot < parts_.size(); ++slot) {
    if (!views_[slot]) continue;
    const Block dp = step.segment<kBlock>(column(slot));
    const double depth = parts_[slot].depth;
    state.cameras[slot] = moved(state.cameras[slot], {dp[0], dp[1], dp[2]}, depth * glm::dvec3(dp[3], dp[4], dp[5]));
    state.gain[slot] *= std::exp(dp[6]);
  }
  for (std::size_t lens = 0; lens < slots_of_lenses_.size(); ++lens) {
    for (int i = 0; i < kBlock; ++i) {
      if (terms_[lens][static_cast<std::size_t>(i)]) state.shared[lens][i] += step[lens_column(lens) + i];
    }
  }
  return state;
}

void JointSolver::measure_noise() {
  noise_ = 1;
  std::vector<double> differences;
  for (const Linearised& linear : linearise(state_, &ViewPart::points, 0, false)) {
    for (const double r : linear.r) differences.push_back(std::abs(r));
  }
  noise_ = std::max(kSmallestNoise, kDeviationOfMedian * upper_median(differences));
}

void JointSolver::refine(std::span<const std::uint32_t> rounds) {
  JointState state = state_;
  std::vector<Linearised> finest = linearise(state);
  double least = noise_ * squares_of(finest).root_mean();
  for (const std::uint32_t coarser : rounds) {
    if (coarser > 0) {
      state = stepped(state, linearise(state, &ViewPart::points, coarser));
      finest.clear();
      continue;
    }
    if (finest.empty()) finest = linearise(state);
    state = stepped(state, finest);
    finest = linearise(state);
    const double residual = noise_ * squares_of(finest).root_mean();
    const bool rests = residual > (1 - kRests) * least && residual < (1 + kRests) * least;
    if (residual < least) {
      least = residual;
      state_ = state;
    }
    if (rests) return;
  }
}

std::vector<double> JointSolver::held_out_residuals() const {
  const std::vector<Linearised> all = linearise(state_, &ViewPart::held_out);
  std::vector<double> of_lenses;
  for (const std::vector<std::uint32_t>& slots : slots_of_lenses_) {
    Squares squares;
    for (const std::uint32_t slot : slots) squares.add(all[slot]);
    of_lenses.push_back(noise_ * squares.root_mean());
  }
  return of_lenses;
}

double JointSolver::held_out_residual() const {
  return noise_ * squares_of(linearise(state_, &ViewPart::held_out)).root_mean();
}

// Source of the scatter of gradients: White 1980.
std::vector<Block> JointSolver::variances() const {
  const std::vector<Linearised> all = linearise(state_);
  JointEquations normal = normal_equations(state_, all);
  // The columns of the inverse that belong to q: all other parameters are marginalised.
  const Eigen::Index columns = lens_column(slots_of_lenses_.size());
  const Eigen::MatrixXd inverse = solve_positive_definite(normal.H, Eigen::MatrixXd::Identity(normal.H.rows(), columns),
                                                          options_.interruption_point);
  Eigen::VectorXd observed = Eigen::VectorXd::Zero(columns);
  for (const ViewGradient& gradient : normal.of_views) {
    Eigen::VectorXd moved = Eigen::VectorXd::Zero(columns);
    for (std::size_t i = 0; i < gradient.blocks.size(); ++i) {
      moved += inverse.middleRows<kBlock>(static_cast<Eigen::Index>(kBlock * gradient.blocks[i])).transpose() *
               gradient.values[i];
    }
    observed += moved.cwiseAbs2();
  }
  const double mean_square = std::pow(squares_of(all).root_mean(), 2);
  std::vector<Block> result;
  for (std::size_t lens = 0; lens < slots_of_lenses_.size(); ++lens) {
    const Eigen::Index first = lens_column(lens);
    const Block modelled = kChannels * mean_square * inverse.block<kBlock, kBlock>(first, first).diagonal().eval();
    result.push_back(kCountedTwice * modelled.cwiseMax(observed.segment<kBlock>(first)));
  }
  return result;
}

}  // namespace lumatlas
