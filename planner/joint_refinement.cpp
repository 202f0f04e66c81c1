// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/joint_refinement.h"

#include <ceres/ceres.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <exception>
#include <memory>
#include <utility>

#include "mesh/base/median.h"
#include "planner/photometry.h"
#include "planner/requirement.h"

namespace lumatlas {

namespace {

constexpr double kLogGainDeviation = 0.05;  // weak knowledge: exposures are balanced before
constexpr std::uint32_t kDenseViews = 150;  // up to so many, all views see each other's points as good as always
constexpr double kRests = 1e-3;             // a step that lowers the sum of squares by less than this share is the last
constexpr std::size_t kSightsPerTask = 512;

// What is solved for of a view. Together in memory, because Ceres eliminates in the order of addresses, which must not
// depend on where the allocator puts things.
struct Own {
  PoseOffset pose{};
  double log_gain = 0;  // of the brightness
};
struct State {
  std::vector<Own> own;            // by slot
  std::vector<double> brightness;  // by point
};

// All that depends on the photographs, computed by all threads before Ceres asks for one residual after the other.
// Ceres itself works on one thread, because its sums would depend on how many there are.
class Sightings : public ceres::EvaluationCallback {
 public:
  Sightings(std::span<const std::optional<ComparedView>> views, const std::vector<PoseFrame>& frames,
            const SeenPoints& points, const State& state, const InterruptionPoint& interruption_point)
      : views_(views),
        frames_(frames),
        points_(points),
        state_(state),
        interruption_point_(interruption_point),
        point_of_(points.sights.size()),
        seen_(points.sights.size()) {
    for (std::size_t point = 0; point < points.positions.size(); ++point) {
      std::fill(point_of_.begin() + static_cast<std::ptrdiff_t>(points.first[point]),
                point_of_.begin() + static_cast<std::ptrdiff_t>(points.first[point + 1]), point);
    }
  }

  void set_level(std::uint32_t coarser) { coarser_ = coarser; }
  void set_noise(double noise) { noise_ = noise; }
  [[nodiscard]] double noise() const { return noise_; }
  [[nodiscard]] const Brightness& seen(std::size_t sight) const { return seen_[sight]; }
  [[nodiscard]] std::size_t point_of(std::size_t sight) const { return point_of_[sight]; }

  void look() {
    std::vector<Camera> cameras(frames_.size());
    for (std::size_t slot = 0; slot < frames_.size(); ++slot) {
      cameras[slot] = camera_at(frames_[slot], state_.own[slot].pose);
    }
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, points_.sights.size(), kSightsPerTask), [&](const auto& range) {
          may_interrupt(interruption_point_);
          for (std::size_t i = range.begin(); i != range.end(); ++i) {
            const Sight& sight = points_.sights[i];
            seen_[i] = brightness_at(*views_[sight.slot], frames_[sight.slot], state_.own[sight.slot].pose,
                                     cameras[sight.slot], static_cast<double>(sight.level) + coarser_,
                                     points_.positions[point_of_[i]]);
          }
        });
  }

  // Ceres cannot be left by an exception without leaks, so the rest of the solution is made short.
  void PrepareForEvaluation(bool, bool) override {
    if (interrupted_) return;
    try {
      look();
    } catch (...) {
      interrupted_ = std::current_exception();
    }
  }
  [[nodiscard]] const std::exception_ptr& interrupted() const { return interrupted_; }

 private:
  std::span<const std::optional<ComparedView>> views_;
  const std::vector<PoseFrame>& frames_;
  const SeenPoints& points_;
  const State& state_;
  const InterruptionPoint& interruption_point_;
  std::vector<std::size_t> point_of_;  // by sight
  std::vector<Brightness> seen_;
  std::uint32_t coarser_ = 0;
  double noise_ = 1;
  std::exception_ptr interrupted_;
};

// Parameters: the point's brightness, the view's pose offset and log gain.
class SightCost : public ceres::SizedCostFunction<1, 1, 6, 1> {
 public:
  SightCost(const Sightings& sightings, std::size_t sight) : sightings_(&sightings), sight_(sight) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    if (sightings_->interrupted()) return false;
    const Brightness& seen = sightings_->seen(sight_);
    const double unit = 1 / sightings_->noise();
    const double gain = seen.inside ? std::exp(parameters[2][0]) : 0;
    // As bad as any outlier, so that nothing is won by turning away.
    residuals[0] = seen.inside ? unit * (seen.value - gain * parameters[0][0]) : 2 * kTukeyCutoff;
    if (!jacobians) return true;
    if (jacobians[0]) jacobians[0][0] = -unit * gain;
    if (jacobians[1]) {
      std::transform(seen.by_pose.begin(), seen.by_pose.end(), jacobians[1], [&](double d) { return unit * d; });
    }
    if (jacobians[2]) jacobians[2][0] = -unit * gain * parameters[0][0];
    return true;
  }

 private:
  const Sightings* sightings_;
  std::size_t sight_;
};

// The weak pull of a pose towards the given one: see pose_pull().
class PosePull : public ceres::SizedCostFunction<6, 6> {
 public:
  PosePull(double strength, const PoseOffset& given) : strength_(strength), given_(given) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    for (std::size_t i = 0; i < 6; ++i) residuals[i] = strength_ * (parameters[0][i] - given_[i]);
    if (!jacobians || !jacobians[0]) return true;
    std::fill(jacobians[0], jacobians[0] + 36, 0.0);
    for (std::size_t i = 0; i < 6; ++i) jacobians[0][7 * i] = strength_;
    return true;
  }

 private:
  double strength_;
  PoseOffset given_;
};

// And that of a log gain towards 0.
class GainPull : public ceres::SizedCostFunction<1, 1> {
 public:
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = parameters[0][0] / kLogGainDeviation;
    if (jacobians && jacobians[0]) jacobians[0][0] = 1 / kLogGainDeviation;
    return true;
  }
};

class StopWhenInterrupted : public ceres::IterationCallback {
 public:
  explicit StopWhenInterrupted(const Sightings& sightings) : sightings_(sightings) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return sightings_.interrupted() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const Sightings& sightings_;
};

class JointSolver {
 public:
  JointSolver(std::span<const std::optional<ComparedView>> views, std::span<const Camera> given, PointSplit split,
              const JointOptions& options)
      : views_(views),
        given_(given),
        split_(std::move(split)),
        options_(options),
        frames_(views.size()),
        fitted_(views, frames_, split_.fitted, state_, options_.interruption_point),
        held_out_(views, frames_, split_.held_out, state_, options_.interruption_point) {
    for (std::size_t slot = 0; slot < views.size(); ++slot) {
      if (views[slot]) frames_[slot] = {views[slot]->view->camera, split_.depth[slot] > 0 ? split_.depth[slot] : 1};
    }
    state_.own.assign(views.size(), Own{});
    state_.brightness.assign(split_.fitted.positions.size(), 0);
  }

  [[nodiscard]] JointRefinement refine() {
    JointRefinement result;
    result.views = static_cast<std::uint32_t>(
        std::count_if(split_.depth.begin(), split_.depth.end(), [](double depth) { return depth > 0; }));
    result.points = split_.fitted.positions.size();
    result.sights = split_.fitted.sights.size();
    if (result.views > 0) solve(result);
    for (std::size_t slot = 0; slot < views_.size(); ++slot) {
      const bool took_part = views_[slot] && split_.depth[slot] > 0;
      result.cameras.push_back(took_part ? camera_at(frames_[slot], state_.own[slot].pose) : frames_[slot].camera);
      result.gain.push_back(took_part ? std::exp(-state_.own[slot].log_gain / kBrightnessPower) : 1);
    }
    return result;
  }

 private:
  void solve(JointRefinement& result) {
    ceres::Problem::Options ownership;
    ownership.evaluation_callback = &fitted_;
    ownership.cost_function_ownership = ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(ownership);
    add_residuals(problem);
    const std::uint32_t levels = std::min(options_.alignment.levels, coarsest_levels());
    for (std::uint32_t coarser = levels; coarser-- > 0;) {
      fitted_.set_level(coarser);
      start_brightnesses();
      solve_level(problem, result);
    }
    start_brightnesses();  // and the noise, by which both are judged
    result.residual_after = held_out_residual();
    const State refined = state_;
    std::fill(state_.own.begin(), state_.own.end(), Own{});
    result.residual_before = held_out_residual();
    // Poses that are right to what the mesh and the photographs allow are better left where they are: what a joint
    // optimum gains there is paid by whoever draws from the given poses.
    if (!(result.residual_after < (1 - options_.alignment.least_improvement) * given_residual())) {
      result.residual_after = result.residual_before;
      return;
    }
    state_ = refined;
  }

  // Of the given poses with the gains as they are now. Leaves both offsets at 0.
  [[nodiscard]] double given_residual() {
    for (std::size_t slot = 0; slot < views_.size(); ++slot) {
      if (split_.depth[slot] > 0) state_.own[slot].pose = offset_of(frames_[slot], given_[slot]);
    }
    const double residual = held_out_residual();
    std::fill(state_.own.begin(), state_.own.end(), Own{});
    return residual;
  }

  // How many levels all pyramids have.
  [[nodiscard]] std::uint32_t coarsest_levels() const {
    std::uint32_t levels = ~0u;
    for (const auto& view : views_) {
      if (view) levels = std::min(levels, view->pyramid.levels());
    }
    return levels;
  }

  void add_residuals(ceres::Problem& problem) {
    for (std::size_t i = 0; i < split_.fitted.sights.size(); ++i) {
      costs_.emplace_back(fitted_, i);
      const std::uint32_t slot = split_.fitted.sights[i].slot;
      problem.AddResidualBlock(&costs_.back(), &loss_, &state_.brightness[fitted_.point_of(i)],
                               state_.own[slot].pose.data(), &state_.own[slot].log_gain);
    }
    for (std::size_t slot = 0; slot < views_.size(); ++slot) {
      if (!problem.HasParameterBlock(&state_.own[slot].log_gain)) continue;
      const double pull = pose_pull(options_.alignment, frames_[slot].camera, split_.per_view[slot] / 3);
      pulls_.emplace_back(pull, offset_of(frames_[slot], given_[slot]));
      problem.AddResidualBlock(&pulls_.back(), nullptr, state_.own[slot].pose.data());
      problem.AddResidualBlock(&gain_pull_, nullptr, &state_.own[slot].log_gain);
      // A view that shows others' points but has too few of its own is there to compare with.
      const bool takes_part = split_.depth[slot] > 0;
      if (!takes_part || !options_.alignment.pose) problem.SetParameterBlockConstant(state_.own[slot].pose.data());
      if (!takes_part || !options_.alignment.exposure) problem.SetParameterBlockConstant(&state_.own[slot].log_gain);
    }
  }

  // Each point's starts at what most views agree on.
  void start_brightnesses() {
    fitted_.look();
    const SeenPoints& points = split_.fitted;
    std::vector<double> all;
    std::vector<double> values;
    for (std::size_t point = 0; point < points.positions.size(); ++point) {
      values.clear();
      for (std::size_t i = points.first[point]; i < points.first[point + 1]; ++i) {
        if (fitted_.seen(i).inside) values.push_back(exposed(fitted_.seen(i).value, points.sights[i].slot));
      }
      if (values.empty()) continue;
      state_.brightness[point] = median(values);
      for (const double value : values) all.push_back(std::abs(value - state_.brightness[point]));
    }
    noise_ = all.empty() ? kSmallestNoise : std::max(kSmallestNoise, kDeviationOfMedian * upper_median(all));
    fitted_.set_noise(noise_);
  }

  [[nodiscard]] double exposed(double value, std::uint32_t slot) const {
    return value * std::exp(-state_.own[slot].log_gain);
  }

  void solve_level(ceres::Problem& problem, JointRefinement& result) {
    ceres::Solver::Options options;
    options.num_threads = 1;
    options.max_num_iterations = static_cast<int>(options_.max_iterations);
    options.function_tolerance = kRests;
    options.logging_type = ceres::SILENT;
    options.linear_solver_type = result.views <= kDenseViews ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
    options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (double& brightness : state_.brightness) {
      if (problem.HasParameterBlock(&brightness)) options.linear_solver_ordering->AddElementToGroup(&brightness, 0);
    }
    for (std::size_t slot = 0; slot < views_.size(); ++slot) {
      if (!problem.HasParameterBlock(&state_.own[slot].log_gain)) continue;
      options.linear_solver_ordering->AddElementToGroup(state_.own[slot].pose.data(), 1);
      options.linear_solver_ordering->AddElementToGroup(&state_.own[slot].log_gain, 1);
    }
    StopWhenInterrupted stop(fitted_);
    options.callbacks.push_back(&stop);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (fitted_.interrupted()) std::rethrow_exception(fitted_.interrupted());
    result.iterations += static_cast<std::uint32_t>(summary.iterations.size());
  }

  // Of the finest level.
  [[nodiscard]] double held_out_residual() {
    const SeenPoints& points = split_.held_out;
    held_out_.look();
    double sum = 0;
    std::size_t sights = 0;
    std::vector<double> values;
    for (std::size_t point = 0; point < points.positions.size(); ++point) {
      values.clear();
      for (std::size_t i = points.first[point]; i < points.first[point + 1]; ++i) {
        if (held_out_.seen(i).inside) values.push_back(exposed(held_out_.seen(i).value, points.sights[i].slot));
      }
      const std::size_t all = points.first[point + 1] - points.first[point];
      sights += all;
      sum += static_cast<double>(all - values.size()) * std::pow(tukey(kTukeyCutoff).value, 2);
      if (values.empty()) continue;
      const double mean = robust_mean(values, noise_);
      for (const double value : values) sum += std::pow(tukey((value - mean) / noise_).value, 2);
    }
    return sights > 0 ? noise_ * std::sqrt(sum / static_cast<double>(sights)) : 0;
  }

  std::span<const std::optional<ComparedView>> views_;
  std::span<const Camera> given_;
  PointSplit split_;
  const JointOptions& options_;
  std::vector<PoseFrame> frames_;  // by slot
  State state_;
  Sightings fitted_, held_out_;
  double noise_ = 1;  // of the differences
  ceres::TukeyLoss loss_{kTukeyCutoff};
  GainPull gain_pull_;
  std::deque<SightCost> costs_;  // which cannot be moved
  std::deque<PosePull> pulls_;
};

}  // namespace

JointRefinement refine_jointly(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
                               std::span<const Camera> given, std::span<const std::vector<SurfaceSample>> samples,
                               const JointOptions& options) {
  constexpr Requirement require{"joint refinement"};
  check(options.alignment);
  require(options.most_points >= 1, "most_points", 0, "at least 1");
  require(options.max_iterations >= 1, "max_iterations", 0, "at least 1");
  require.has_size(views.size(), atlas.capacity(), "views", "the atlas's capacity");
  require.has_size(given.size(), atlas.capacity(), "given", "the atlas's capacity");
  require.has_size(samples.size(), atlas.capacity(), "samples", "the atlas's capacity");
  const std::size_t faces = atlas.surface().cells.cell_of_face.size();
  for (const std::vector<SurfaceSample>& of_view : samples) {
    for (const SurfaceSample& sample : of_view) require.is_below(sample.face, faces, "a sample's face", "the faces");
  }
  return JointSolver(views, given, split_points(atlas, views, samples, options.most_points), options).refine();
}

}  // namespace lumatlas
