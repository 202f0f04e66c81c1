// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/joint/joint_solver.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "mesh/base/median.h"
#include "planner/refinement/joint/conjugate_gradients.h"
#include "planner/refinement/photometry.h"

namespace lumatlas {

namespace {

constexpr double kRidge = 1e-7;  // share of the normal matrix' mean diagonal: for views that nothing else holds
constexpr int kAttempts = 4;     // at a step that lowers the cost
constexpr double kLeastDamping = 0.01, kDampingFactor = 30;
constexpr double kMostLost = 0.1;  // share of the compared points that a step may lose
constexpr double kRests = 2e-4;    // a round that changes the residual by less is the last
constexpr double kFixed = 1e6;     // times the normal matrix' trace: for views that take no part
constexpr double kMotionPull = 1;  // of motions towards 0, times that of poses towards the given ones
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

void check_least_improvement(double share, const Requirement& requires_) {
  requires_(share > 0 && share < 1, "least_improvement", share, "in (0, 1)");
}

void check(const JointInput& input, std::size_t most_points, const Requirement& requires_) {
  requires_(most_points >= 1, "most_points", 0, "at least 1");
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
      problem_(input.atlas, input.views, input.samples, found_lenses(), options.most_points, options.cancel_check),
      parts_(problem_.parts()) {
  blocks_ = slots_of_lenses_.size();
  block_of_.own.assign(views_.size(), 0);
  for (std::size_t slot = 0; slot < views_.size(); ++slot) {
    if (views_[slot]) block_of_.own[slot] = blocks_++;
  }
  state_.lens_parameters.assign(slots_of_lenses_.size(), Block::Zero());
  state_.gain.assign(views_.size(), 1);
  state_.motion.assign(views_.size(), Block::Zero());
  terms_.assign(slots_of_lenses_.size(), Terms{});
  count_operations();
}

// Finds the lens of each view slot from the cameras of the stored views, which the state gets.
std::vector<std::size_t> JointSolver::found_lenses() {
  state_.cameras.resize(views_.size());
  std::vector<std::size_t> lens_of(views_.size(), 0);
  for (ViewSlot slot{0}; slot < views_.size(); ++slot) {
    if (!views_[slot]) continue;
    const Camera& camera = views_[slot]->camera;
    state_.cameras[slot] = camera;
    const auto same = std::find_if(
        slots_of_lenses_.begin(), slots_of_lenses_.end(),
        [&](const std::vector<ViewSlot>& slots) { return share_a_lens(state_.cameras[slots.front()], camera); });
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

// The pattern, which takes time to find, is looked at only where a dense factor would take too much.
void JointSolver::count_operations() {
  operations_ = dense_factor_operations(blocks_);
  if (operations_ <= options_.most_operations) return;
  operations_ = factor_operations(joint_pattern(problem_, blocks_, block_of_, options_.cancel_check));
}

Eigen::VectorXd JointSolver::solved(const BlockMatrix& H, const Eigen::VectorXd& b) const {
  if (takes_more_than(options_.most_operations)) return solve_by_gradients(H, b, {}, options_.cancel_check).x;
  return BlockFactor(H, options_.cancel_check).solve(b, options_.cancel_check);
}

void JointSolver::set_estimated(std::size_t lens, std::size_t parameter, bool estimated) {
  terms_[lens][parameter] = estimated;
  if (!estimated) state_.lens_parameters[lens][static_cast<Eigen::Index>(parameter)] = 0;
}

void JointSolver::estimate_motions() {
  if (!block_of_.motion.empty()) return;
  block_of_.motion.assign(views_.size(), 0);
  for (std::size_t slot = 0; slot < views_.size(); ++slot) {
    if (views_[slot]) block_of_.motion[slot] = blocks_++;
  }
  count_operations();
}

std::vector<Linearised> JointSolver::linearise(const JointState& state, std::vector<ComparedPoint> ViewPart::*points,
                                               std::uint32_t coarser, bool robust) const {
  return problem_.linearise(state, points, coarser, noise_, robust);
}

Eigen::Index JointSolver::column(std::size_t slot) const {
  return static_cast<Eigen::Index>(kBlock * block_of_.own[slot]);
}

// A parameter that is not estimated has the prior alone, and so stays 0.
JointEquations JointSolver::normal_equations(const JointState& state, const std::vector<Linearised>& all) const {
  std::vector<Block> estimated;
  for (const Terms& terms : terms_) {
    estimated.emplace_back(
        Block::NullaryExpr([&](Eigen::Index i) { return terms[static_cast<std::size_t>(i)] ? 1.0 : 0.0; }));
  }
  JointEquations normal = joint_equations(problem_, state, all, estimated, blocks_, block_of_, options_.cancel_check);
  const double ridge = kRidge * (normal.H.trace() / static_cast<double>(kBlock * blocks_) + 1);
  for (std::size_t block = 0; block < blocks_; ++block) normal.H.at(block, block).diagonal().array() += ridge;
  const Block prior = kPrior.array().square().inverse();
  for (std::size_t lens = 0; lens < slots_of_lenses_.size(); ++lens) {
    normal.H.at(lens, lens).diagonal() += prior;
    normal.g.segment<kBlock>(lens_column(lens)) += prior.cwiseProduct(state.lens_parameters[lens]);
  }
  add_pulls(state, normal);
  return normal;
}

// The distance of a view from its given pose, times the strength with which it is pulled back.
JointSolver::PoseBlock JointSolver::pulled(const JointState& state, ViewSlot slot) const {
  const auto [turn, shift] = motion_between(given_[slot], state.cameras[slot]);
  const double depth = parts_[slot].depth;
  return pull_of(state, slot) *
         (PoseBlock() << turn.x, turn.y, turn.z, shift.x / depth, shift.y / depth, shift.z / depth).finished();
}

double JointSolver::pull_of(const JointState& state, ViewSlot slot) const {
  return pose_pull(options_.alignment, state.cameras[slot], parts_[slot].points.size());
}

Eigen::Index JointSolver::motion_column(std::size_t slot) const {
  return static_cast<Eigen::Index>(kBlock * block_of_.motion[slot]);
}

double JointSolver::motion_pull_of(const JointState& state, ViewSlot slot) const {
  return kMotionPull * pull_of(state, slot);
}

// Adds the pulls towards the given poses, as when views are aligned one by one. Without them, a change of the focal
// length for which all views move along their axes would cost nothing, and pictures drawn from the given poses would
// show the loss.
void JointSolver::add_pulls(const JointState& state, JointEquations& normal) const {
  const double fixed = kFixed * normal.H.trace();
  for (ViewSlot slot{0}; slot < parts_.size(); ++slot) {
    if (!views_[slot]) continue;
    BlockSquare& own = normal.H.at(block_of_.own[slot], block_of_.own[slot]);
    // Else it would follow those that are compared with it.
    if (parts_[slot].points.empty()) own.diagonal().array() += fixed;
    const double pull = pull_of(state, slot);
    own.diagonal().head<kPose>().array() += pull * pull;
    normal.g.segment<kPose>(column(slot)) += pull * pulled(state, slot);
    if (block_of_.motion.empty()) continue;
    BlockSquare& motion = normal.H.at(block_of_.motion[slot], block_of_.motion[slot]);
    if (parts_[slot].points.empty()) motion.diagonal().array() += fixed;
    const double strength = motion_pull_of(state, slot);
    motion.diagonal().array() += strength * strength;
    normal.g.segment<kBlock>(motion_column(slot)) += strength * strength * state.motion[slot];
  }
}

JointState JointSolver::moved_by(const JointState& from, const Eigen::VectorXd& step) const {
  JointState state = from;
  for (ViewSlot slot{0}; slot < parts_.size(); ++slot) {
    if (!views_[slot]) continue;
    const Block dp = step.segment<kBlock>(column(slot));
    const double depth = parts_[slot].depth;
    state.cameras[slot] = moved(state.cameras[slot], {dp[0], dp[1], dp[2]}, depth * glm::dvec3(dp[3], dp[4], dp[5]));
    state.gain[slot] *= std::exp(dp[kPose]);
    if (!block_of_.motion.empty()) state.motion[slot] += step.segment<kBlock>(motion_column(slot));
  }
  for (std::size_t lens = 0; lens < slots_of_lenses_.size(); ++lens) {
    for (int i = 0; i < kBlock; ++i) {
      if (terms_[lens][static_cast<std::size_t>(i)]) state.lens_parameters[lens][i] += step[lens_column(lens) + i];
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

double JointSolver::prior_cost(const JointState& state) const {
  double sum = 0;
  for (const Block& q : state.lens_parameters) sum += q.cwiseQuotient(kPrior).squaredNorm();
  for (ViewSlot slot{0}; slot < parts_.size(); ++slot) {
    if (!views_[slot]) continue;
    sum += pulled(state, slot).squaredNorm();
    sum += std::pow(motion_pull_of(state, slot), 2) * state.motion[slot].squaredNorm();
  }
  return sum;
}

JointSolver::Fit JointSolver::fit(const JointState& state, std::uint32_t coarser) const {
  return {state, linearise(state, &ViewPart::points, coarser)};
}

// Returns by how much the cost is lower than now, at the points that both states compare; 0 for a step that loses too
// many points. A point that has just left the image would count as an outlier, which is more than most steps gain, and
// says nothing about the poses.
double JointSolver::gain_of(const Fit& next, const Fit& now) const {
  double gain = prior_cost(now.state) - prior_cost(next.state), compared = 0, lost = 0;
  for (std::size_t slot = 0; slot < now.rows.size(); ++slot) {
    const Linearised &before = now.rows[slot], &after = next.rows[slot];
    for (std::size_t point = 0; point < before.compared.size(); ++point) {
      if (!before.compared[point]) continue;
      ++compared;
      const auto row = static_cast<Eigen::Index>(3 * point);
      if (after.compared[point]) {
        gain += before.r.segment<3>(row).squaredNorm() - after.r.segment<3>(row).squaredNorm();
      } else {
        ++lost;
      }
    }
  }
  return lost <= kMostLost * compared ? gain : 0;
}

// The damping multiplies the diagonal of the normal equations (Levenberg-Marquardt).
bool JointSolver::improve(Fit& at, std::uint32_t coarser) {
  JointEquations normal = normal_equations(at.state, at.rows);
  std::vector<Block> diagonals;
  for (std::size_t block = 0; block < blocks_; ++block) diagonals.emplace_back(normal.H.at(block, block).diagonal());
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    for (std::size_t block = 0; block < blocks_; ++block) {
      normal.H.at(block, block).diagonal() = (1 + damping_) * diagonals[block];
    }
    const Eigen::VectorXd step = -solved(normal.H, normal.g);
    Fit next = fit(moved_by(at.state, step), coarser);
    const double gain = gain_of(next, at);
    if (gain > 0) {
      steps_.push_back({coarser, gain, damping_});
      at = std::move(next);
      damping_ = damping_ > kLeastDamping ? damping_ / kDampingFactor : 0;
      return true;
    }
    damping_ = std::max(kDampingFactor * damping_, kLeastDamping);
  }
  return false;
}

void JointSolver::refine(std::span<const std::uint32_t> rounds) {
  damping_ = 0;
  steps_.clear();
  Fit at = fit(state_, 0);
  double least = squares_of(at.rows).root_mean();
  std::uint32_t level = 0;  // that `at` is of
  for (auto round = rounds.begin(); round != rounds.end(); ++round) {
    const std::uint32_t coarser = *round;
    if (coarser != level) at = fit(at.state, coarser);
    level = coarser;
    if (!improve(at, coarser)) {  // the rounds of this level that are left would find no more
      while (std::next(round) != rounds.end() && *std::next(round) == coarser) ++round;
      damping_ = 0;
      continue;
    }
    if (coarser != 0) continue;
    const double now = squares_of(at.rows).root_mean();
    const bool rests = now > (1 - kRests) * least && now < (1 + kRests) * least;
    if (now < least) {
      least = now;
      state_ = at.state;
    }
    if (rests) return;
  }
}

std::vector<double> JointSolver::held_out_residuals() const {
  const std::vector<Linearised> all = linearise(state_, &ViewPart::held_out);
  std::vector<double> of_lenses;
  for (const std::vector<ViewSlot>& slots : slots_of_lenses_) {
    Squares squares;
    for (const ViewSlot slot : slots) squares.add(all[slot]);
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
  const JointEquations normal = normal_equations(state_, all);
  // The columns of the inverse that belong to q: all other parameters are marginalised.
  const Eigen::Index columns = lens_column(slots_of_lenses_.size());
  const Eigen::MatrixXd inverse =
      BlockFactor(normal.H, options_.cancel_check)
          .solve(Eigen::MatrixXd::Identity(normal.g.size(), columns), options_.cancel_check);
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
    result.emplace_back(kCountedTwice * modelled.cwiseMax(observed.segment<kBlock>(first)));
  }
  return result;
}

}  // namespace lumatlas
