// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: Erat et al. 2019, section 3.3; Ceres's TinySolver for the small dense problem that each level is.
#include "planner/refinement/alignment.h"

#include <ceres/tiny_solver.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "atlas/images/srgb.h"
#include "mesh/base/median.h"
#include "mesh/base/requirement.h"
#include "planner/refinement/photometry.h"

namespace lumatlas {

namespace {

constexpr int kPoseParameters = 6;
constexpr std::uint32_t kCorrelationPx = 320;
constexpr std::uint32_t kTiles = 4;
constexpr double kFewestTilePoints = 20;
constexpr double kPlain = 1.0 / 255;  // standard deviation of luma, sRGB, below which there is no texture
constexpr std::size_t kPointsPerTask = 256;

// The starting point of the parameters: the given camera, and units in which a unit of each pose parameter moves the
// image about as far as any other.
struct Frame {
  Camera camera;
  double depth = 1;  // median of the points
};

// The camera frame is turned by `pose[0..2]` (a rotation vector), then moved by `pose[3..5]` times the frame's depth.
Camera moved_camera(const Frame& frame, const double* pose) {
  return moved(frame.camera, glm::dvec3(pose[0], pose[1], pose[2]),
               frame.depth * glm::dvec3(pose[3], pose[4], pose[5]));
}

// The parameters that moved_camera() makes `camera` from.
Eigen::Matrix<double, kPoseParameters, 1> pose_of(const Frame& frame, const Camera& camera) {
  const auto [turn, shift] = motion_between(frame.camera, camera);
  return {turn.x, turn.y, turn.z, shift.x / frame.depth, shift.y / frame.depth, shift.z / frame.depth};
}

// The position of a point in a photograph.
struct ImagePoint {
  glm::dvec3 cam;
  glm::dvec2 image;
};

// Returns nothing behind the camera, outside the image, or where the photograph has no colour.
std::optional<ImagePoint> image_point(const Camera& camera, const Pyramid& photograph, const glm::dvec3& position) {
  const glm::dvec3 cam = camera.cam_from_world(position);
  if (!(cam.z > 0)) return std::nullopt;
  const glm::dvec2 image = camera.image_from_cam(cam);
  const bool inside = image.x >= 0 && image.y >= 0 && image.x < camera.width && image.y < camera.height;
  if (!inside || !photograph.is_valid(image)) return std::nullopt;
  return ImagePoint{cam, image};
}

// The weight of a difference from the targets' colours at a level, by channel: the same for every pose and exposure.
std::vector<glm::dvec3> slopes_at(const std::vector<glm::vec3>& colors) {
  std::vector<glm::dvec3> slopes(colors.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, colors.size(), kPointsPerTask),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i != range.end(); ++i) {
                        const glm::dvec3 color(colors[i]);
                        slopes[i] = {srgb_slope(color.r), srgb_slope(color.g), srgb_slope(color.b)};
                      }
                    });
  return slopes;
}

// The targets and the photograph that is aligned to them; `gain` is the starting exposure.
struct Problem {
  glm::dvec3 gain;
  const Pyramid& photograph;
  const AlignmentTargets& targets;
  const std::vector<std::vector<glm::dvec3>>& slopes;  // slopes_at() each level that is compared
  AlignmentOptions options;

  // The same where pose, or pose and exposure, are taken as they are.
  [[nodiscard]] Problem of_exposure() const {
    Problem problem = *this;
    problem.options.pose = false;
    return problem;
  }
  [[nodiscard]] Problem of_nothing(const glm::dvec3& with_gain) const {
    Problem problem = of_exposure();
    problem.options.exposure = false;
    problem.gain = with_gain;
    return problem;
  }
};

// The cost function of TinySolver at one level.
class Disagreement {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = Eigen::Dynamic };

  Disagreement(const Frame& frame, const Problem& problem, std::uint32_t level)
      : frame_(frame),
        gain_(problem.gain),
        photograph_(problem.photograph),
        targets_(problem.targets),
        slopes_(problem.slopes[level]),
        level_(level),
        options_(problem.options) {
    pull_ = pose_pull(options_, frame.camera, targets_.positions.size());
    if (!options_.pose) look_once();
  }

  [[nodiscard]] int NumResiduals() const {
    return static_cast<int>(3 * targets_.positions.size()) + (options_.pose ? kPoseParameters : 0);
  }
  [[nodiscard]] int NumParameters() const { return pose_parameters() + gain_parameters(); }
  [[nodiscard]] int pose_parameters() const { return options_.pose ? kPoseParameters : 0; }
  [[nodiscard]] int gain_parameters() const { return !options_.exposure ? 0 : options_.white_balance ? 3 : 1; }

  // The standard deviation of the differences at `parameters`, by their median, sRGB: the unit of the residuals.
  void estimate_noise(const Eigen::VectorXd& parameters) {
    noise_ = 1;
    std::vector<double> residuals(static_cast<std::size_t>(NumResiduals()));
    evaluate(parameters.data(), residuals.data(), nullptr, false);
    residuals.resize(3 * targets_.positions.size());
    for (double& r : residuals) r = std::abs(r);
    noise_ = std::max(kSmallestNoise, kDeviationOfMedian * upper_median(residuals));
  }
  void set_noise(double noise) { noise_ = noise; }
  [[nodiscard]] double noise() const { return noise_; }

  // Root of the mean robust squared difference, sRGB.
  [[nodiscard]] double residual(const Eigen::VectorXd& parameters) const {
    Eigen::VectorXd residuals(NumResiduals());
    evaluate(parameters.data(), residuals.data(), nullptr, true);
    const auto data = residuals.head(static_cast<Eigen::Index>(3 * targets_.positions.size()));
    return noise_ * std::sqrt(data.squaredNorm() / static_cast<double>(data.size()));
  }

  bool operator()(const double* parameters, double* residuals, double* jacobian) const {
    evaluate(parameters, residuals, jacobian, true);
    return true;
  }

  [[nodiscard]] glm::dvec3 gain_at(const double* parameters) const {
    glm::dvec3 gain = gain_;
    if (!options_.exposure) return gain;
    const double* log_gain = parameters + pose_parameters();
    for (int channel = 0; channel < 3; ++channel)
      gain[channel] *= std::exp(log_gain[options_.white_balance ? channel : 0]);
    return gain;
  }
  [[nodiscard]] Camera camera_at(const double* parameters) const {
    return options_.pose ? moved_camera(frame_, parameters) : frame_.camera;
  }

 private:
  void evaluate(const double* parameters, double* residuals, double* jacobian, bool robust) const {
    const auto rows = static_cast<std::size_t>(NumResiduals());
    if (jacobian) std::fill(jacobian, jacobian + rows * static_cast<std::size_t>(NumParameters()), 0.0);
    const Camera camera = camera_at(parameters);
    const glm::dvec3 gain = gain_at(parameters);
    const double still[kPoseParameters] = {};
    const double* pose = options_.pose ? parameters : still;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, targets_.positions.size(), kPointsPerTask),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        for (std::size_t point = range.begin(); point != range.end(); ++point) {
                          point_rows(camera, gain, pose, point, robust, residuals, jacobian);
                        }
                      });
    if (!options_.pose) return;
    const std::size_t first = 3 * targets_.positions.size();
    for (std::size_t i = 0; i < kPoseParameters; ++i) {
      residuals[first + i] = pull_ * parameters[i];
      if (jacobian) jacobian[i * rows + first + i] = pull_;
    }
  }

  // A camera that stays sees the same colours at every exposure.
  void look_once() {
    seen_.resize(targets_.positions.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, seen_.size(), kPointsPerTask),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        for (std::size_t point = range.begin(); point != range.end(); ++point) {
                          const std::optional<ImagePoint> place =
                              image_point(frame_.camera, photograph_, targets_.positions[point]);
                          if (place) seen_[point] = photograph_.color(level_, place->image);
                        }
                      });
  }

  void point_rows(const Camera& camera, const glm::dvec3& gain, const double* pose, std::size_t point, bool robust,
                  double* residuals, double* jacobian) const {
    std::optional<ImagePoint> place;
    std::optional<ColorSample> sample;
    if (options_.pose) {
      place = image_point(camera, photograph_, targets_.positions[point]);
      if (place) sample = photograph_.sample(level_, place->image);
    } else if (seen_[point]) {
      sample = ColorSample{*seen_[point], {}, {}};
    }
    if (!sample) {  // counts like any outlier, so that turning away gains nothing
      for (std::size_t channel = 0; channel < 3; ++channel) {
        residuals[3 * point + channel] = tukey(kTukeyCutoff).value;
      }
      return;
    }
    const glm::dvec3 target(targets_.colors[level_][point]);
    for (int channel = 0; channel < 3; ++channel) {
      const double unit = slopes_[point][channel] / noise_;
      const double difference = unit * (gain[channel] * sample->color[channel] - target[channel]);
      const Robust r = robust ? tukey(difference) : Robust{difference, 1};
      const std::size_t row = 3 * point + static_cast<std::size_t>(channel);
      residuals[row] = r.value;
      if (!jacobian) continue;
      const double slope = r.derivative * unit * gain[channel];
      if (options_.pose) {
        pose_columns(place->cam, pose, slope * glm::dvec2(sample->d_x[channel], sample->d_y[channel]), row, jacobian);
      }
      gain_column(slope * sample->color[channel], channel, row, jacobian);
    }
  }

  // Applies the chain rule to the image gradient: d image / d cam, then d cam / d pose.
  void pose_columns(const glm::dvec3& cam, const double* pose, const glm::dvec2& gradient, std::size_t row,
                    double* jacobian) const {
    const auto rows = static_cast<std::size_t>(NumResiduals());
    const double gx = gradient.x * frame_.camera.fx / cam.z;
    const double gy = gradient.y * frame_.camera.fy / cam.z;
    const glm::dvec3 by_cam(gx, gy, -(gx * cam.x + gy * cam.y) / cam.z);
    const glm::dvec3 rotated = cam - frame_.depth * glm::dvec3(pose[3], pose[4], pose[5]);
    const glm::dvec3 by_turn = glm::cross(rotated, by_cam);
    // A change w of the rotation vector v turns by w + cross(v, w) / 2, to second order.
    const glm::dvec3 by_vector = by_turn - 0.5 * glm::cross(glm::dvec3(pose[0], pose[1], pose[2]), by_turn);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<int>(i);
      jacobian[i * rows + row] = by_vector[axis];
      jacobian[(3 + i) * rows + row] = frame_.depth * by_cam[axis];
    }
  }

  void gain_column(double by_log_gain, int channel, std::size_t row, double* jacobian) const {
    if (!options_.exposure) return;
    const auto rows = static_cast<std::size_t>(NumResiduals());
    const int column = pose_parameters() + (options_.white_balance ? channel : 0);
    jacobian[static_cast<std::size_t>(column) * rows + row] = by_log_gain;
  }

  const Frame& frame_;
  glm::dvec3 gain_;
  const Pyramid& photograph_;
  const AlignmentTargets& targets_;
  const std::vector<glm::dvec3>& slopes_;
  std::uint32_t level_;
  std::vector<std::optional<glm::dvec3>> seen_;  // without options_.pose: linear colours of the points; none: outside
  AlignmentOptions options_;
  double pull_ = 0;
  double noise_ = 1;
};

double median_depth(const Camera& camera, const std::vector<glm::dvec3>& positions) {
  std::vector<double> depths;
  depths.reserve(positions.size());
  for (const glm::dvec3& position : positions) depths.push_back(camera.cam_from_world(position).z);
  return std::max(upper_median(depths), 1e-12);
}

// The median ratio of target and photograph, which needs no start and stands misalignment.
glm::dvec3 median_ratio(const Camera& camera, const Pyramid& photograph, const AlignmentTargets& targets,
                        std::uint32_t level, bool per_channel) {
  std::vector<double> ratios[3];
  for (std::size_t point = 0; point < targets.positions.size(); ++point) {
    const std::optional<ImagePoint> place = image_point(camera, photograph, targets.positions[point]);
    if (!place) continue;
    const glm::dvec3 color = photograph.color(level, place->image);
    const glm::dvec3 target(targets.colors[level][point]);
    for (int channel = 0; channel < 3; ++channel) {
      if (color[channel] > 0) ratios[per_channel ? channel : 0].push_back(target[channel] / color[channel]);
    }
  }
  glm::dvec3 gain(1.0);
  for (int channel = 0; channel < 3; ++channel) {
    std::vector<double>& values = ratios[per_channel ? channel : 0];
    if (!values.empty()) gain[channel] = std::clamp(upper_median(values), 1e-3, 1e3);
  }
  return gain;
}

double displacement_px(const Camera& from, const Camera& to, const std::vector<glm::dvec3>& positions) {
  std::vector<double> moves;
  moves.reserve(positions.size());
  for (const glm::dvec3& position : positions) {
    const glm::dvec3 a = from.cam_from_world(position);
    const glm::dvec3 b = to.cam_from_world(position);
    moves.push_back(a.z > 0 && b.z > 0 ? glm::length(to.image_from_cam(b) - from.image_from_cam(a)) : 1e9);
  }
  return upper_median(moves);
}

// Running sums for the correlation of two series.
struct CorrelationSums {
  double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;

  void add(double first, double second) {
    n += 1;
    a += first;
    b += second;
    aa += first * first;
    bb += second * second;
    ab += first * second;
  }
  [[nodiscard]] bool first_is_plain() const { return aa / n - a * a / (n * n) < kPlain * kPlain; }
  [[nodiscard]] bool second_is_plain() const { return bb / n - b * b / (n * n) < kPlain * kPlain; }
  // 0 if one of them is plain: what is left of it is rounding and noise.
  [[nodiscard]] double correlation() const {
    if (first_is_plain() || second_is_plain()) return 0;
    return (n * ab - a * b) / std::sqrt((n * aa - a * a) * (n * bb - b * b));
  }
};

double luma(const glm::dvec3& linear) {
  const auto srgb = [](double value) { return srgb_from_linear(std::clamp(value, 0.0, 1.0)); };
  return 0.299 * srgb(linear.r) + 0.587 * srgb(linear.g) + 0.114 * srgb(linear.b);
}

// Returns the upper quartile of the luma's correlations in kTiles x kTiles parts of the picture. Half a picture of
// leaves lowers it little, a wrong pose spoils it everywhere. Parts that are plain in both, such as a painted wall, do
// not count.
std::optional<double> correlation(const Camera& camera, const glm::dvec3& gain, const Pyramid& photograph,
                                  const AlignmentTargets& targets) {
  const std::uint32_t level = photograph.level_near(kCorrelationPx);
  std::array<CorrelationSums, std::size_t{kTiles} * kTiles> tiles;
  for (std::size_t point = 0; point < targets.positions.size(); ++point) {
    const std::optional<ImagePoint> place = image_point(camera, photograph, targets.positions[point]);
    if (!place) continue;
    const auto column = static_cast<std::size_t>(place->image.x * kTiles / camera.width);
    const auto row = static_cast<std::size_t>(place->image.y * kTiles / camera.height);
    tiles[row * kTiles + column].add(luma(gain * photograph.color(level, place->image)),
                                     luma(glm::dvec3(targets.colors[level][point])));
  }
  std::vector<double> correlations;
  for (const CorrelationSums& tile : tiles) {
    if (tile.n < kFewestTilePoints || (tile.first_is_plain() && tile.second_is_plain())) continue;
    correlations.push_back(tile.correlation());
  }
  if (correlations.empty()) return std::nullopt;
  const auto quartile = correlations.begin() + static_cast<std::ptrdiff_t>(3 * correlations.size() / 4);
  std::nth_element(correlations.begin(), quartile, correlations.end());
  return *quartile;
}

constexpr Requirement alignment_requires{"alignment"};

void solve(Disagreement& cost, Eigen::VectorXd& parameters, std::uint32_t max_iterations) {
  cost.estimate_noise(parameters);
  if (cost.NumParameters() == 0) return;
  ceres::TinySolver<Disagreement> solver;
  // TinySolver counts the evaluation that it starts with as an iteration: with 1 it would take no step.
  solver.options.max_num_iterations = static_cast<int>(max_iterations) + 1;
  solver.options.function_tolerance = 1e-4 * cost.NumResiduals();
  solver.Solve(cost, &parameters);
}

// A pose with the gain that fits it best.
struct Placed {
  Camera camera;
  glm::dvec3 gain{1.0};
  double noise = 0;     // that it leaves, of the differences at the finest level
  double residual = 0;  // relative to a noise that is the same for all that are compared
};

// Depends on the camera and the gain alone: pose and exposure are taken as they are.
double residual_with(const Problem& problem, const Camera& camera, const glm::dvec3& gain, double noise) {
  const Frame frame{camera, 1};
  Disagreement cost(frame, problem.of_nothing(gain), 0);
  cost.set_noise(noise);
  return cost.residual(Eigen::VectorXd(0));
}

double residual_of(const Problem& problem, const Placed& placed, double noise) {
  return residual_with(problem, placed.camera, placed.gain, noise);
}

// The camera stays where it is.
Placed exposed(const Problem& problem, const Camera& camera) {
  const Frame frame{camera, 1};
  Disagreement cost(frame, problem.of_exposure(), 0);
  Eigen::VectorXd log_gain = Eigen::VectorXd::Zero(cost.NumParameters());
  solve(cost, log_gain, problem.options.max_iterations);
  return {camera, cost.gain_at(log_gain.data()), cost.noise(), 0};
}

// The pose that is found from `start` with a pull towards `given`, coarse to fine.
Placed searched(const Problem& problem, const Camera& given, const Camera& start) {
  const Frame frame{given, median_depth(given, problem.targets.positions)};
  Disagreement finest(frame, problem, 0);
  Eigen::VectorXd parameters = Eigen::VectorXd::Zero(finest.NumParameters());
  parameters.head<kPoseParameters>() = pose_of(frame, start);
  for (auto level = static_cast<std::uint32_t>(problem.slopes.size()); level-- > 0;) {
    Disagreement cost(frame, problem, level);
    solve(cost, parameters, problem.options.max_iterations);
  }
  finest.estimate_noise(parameters);
  return {finest.camera_at(parameters.data()), finest.gain_at(parameters.data()), finest.noise(),
          finest.residual(parameters)};
}

// The refined pose if it is better than the given one by enough and within the bound. But the search stays where it
// started, at a pose that is, if it would leave it for one that is no better or cannot be told from it.
Placed best_placed(const Problem& problem, const Camera& given, const Placed& as_given, const Placed& as_started,
                   const Placed& refined) {
  const AlignmentOptions& options = problem.options;
  const double longer_side = std::max(given.width, given.height);
  const auto is_accepted = [&](const Placed& placed) {
    return placed.residual < (1 - options.least_improvement) * as_given.residual &&
           displacement_px(given, placed.camera, problem.targets.positions) <= options.max_move * longer_side;
  };
  if (!is_accepted(refined)) return as_given;
  if (!same_pose(as_started.camera, given) && is_accepted(as_started) &&
      (refined.residual >= as_started.residual ||
       displacement_px(as_started.camera, refined.camera, problem.targets.positions) < options.least_move_px)) {
    return as_started;
  }
  return refined;
}

void check_input(const Camera& given, const Camera& start, const glm::dvec3& gain, const Pyramid& photograph,
                 const AlignmentTargets& targets, const AlignmentOptions& options) {
  check(given);
  check(start);
  const PhotographSpan& finest = photograph.level(0);
  alignment_requires(given.width == finest.width, "given.width", given.width, "the photograph's");
  alignment_requires(given.height == finest.height, "given.height", given.height, "the photograph's");
  alignment_requires(start.width == given.width, "start.width", start.width, "given.width");
  alignment_requires(start.height == given.height, "start.height", start.height, "given.height");
  alignment_requires(start.fx == given.fx, "start.fx", start.fx, "given.fx");
  alignment_requires(start.fy == given.fy, "start.fy", start.fy, "given.fy");
  alignment_requires(start.cx == given.cx, "start.cx", start.cx, "given.cx");
  alignment_requires(start.cy == given.cy, "start.cy", start.cy, "given.cy");
  for (int channel = 0; channel < 3; ++channel) {
    alignment_requires(std::isfinite(gain[channel]) && gain[channel] > 0, "gain", gain[channel], "finite and positive");
  }
  alignment_requires.has_size(targets.colors.size(), photograph.levels(), "targets.colors",
                              "the number of the pyramid's levels");
  for (std::uint32_t level = 0; level < photograph.levels(); ++level) {
    if (!needs_level(options, photograph, level) && targets.colors[level].empty()) continue;
    alignment_requires.has_size(targets.colors[level].size(), targets.positions.size(), "a level of targets.colors",
                                "the number of the positions");
  }
}

}  // namespace

void check(const AlignmentOptions& options) {
  alignment_requires(std::isfinite(options.max_move) && options.max_move > 0, "max_move", options.max_move,
                     "finite and positive");
  alignment_requires(std::isfinite(options.prior) && options.prior >= 0, "prior", options.prior,
                     "finite and not negative");
  alignment_requires(options.least_improvement >= 0 && options.least_improvement < 1, "least_improvement",
                     options.least_improvement, "in [0, 1)");
  alignment_requires(std::isfinite(options.least_move_px) && options.least_move_px >= 0, "least_move_px",
                     options.least_move_px, "finite and not negative");
  alignment_requires(options.levels >= 1, "levels", options.levels, "at least 1");
  alignment_requires(options.max_iterations >= 1, "max_iterations", options.max_iterations, "at least 1");
}

bool needs_level(const AlignmentOptions& options, const Pyramid& photograph, std::uint32_t level) {
  return level < options.levels || (options.exposure && level + 1 == photograph.levels()) ||
         (options.correlation && level == photograph.level_near(kCorrelationPx));
}

double pose_pull(const AlignmentOptions& options, const Camera& camera, std::size_t points) {
  const double reach = options.max_move * std::max(camera.width, camera.height);
  return std::sqrt(3 * options.prior * static_cast<double>(points)) * camera.fx / reach;
}

Alignment align(const Camera& given, const Camera& start, const glm::dvec3& gain, const Pyramid& photograph,
                const AlignmentTargets& targets, const AlignmentOptions& options) {
  check(options);
  check_input(given, start, gain, photograph, targets, options);
  Alignment result;
  result.camera = given;
  result.gain = gain;
  result.moved = !same_pose(given, start);
  if (targets.positions.size() < kFewestAlignmentPoints) return result;
  const glm::dvec3 ratio =
      options.exposure ? median_ratio(start, photograph, targets, photograph.levels() - 1, options.white_balance)
                       : gain;
  std::vector<std::vector<glm::dvec3>> slopes;
  for (std::uint32_t level = 0; level < std::min(options.levels, photograph.levels()); ++level) {
    slopes.push_back(slopes_at(targets.colors[level]));
  }
  const Problem problem{ratio, photograph, targets, slopes, options};
  Placed as_given = exposed(problem, given);
  std::optional<Placed> refined;
  if (options.pose) refined = searched(problem, given, start);

  // All are judged by the noise that the best one leaves.
  const double noise = refined ? refined->noise : as_given.noise;
  result.residual_given = residual_with(problem, given, gain, noise);
  result.residual_exposed = as_given.residual = residual_of(problem, as_given, noise);
  Placed as_started = as_given;
  if (!same_pose(given, start)) {
    as_started = exposed(problem, start);
    as_started.residual = residual_of(problem, as_started, noise);
  }
  result.residual_start = as_started.residual;
  if (refined && as_given.residual > 0) result.found_improvement = 1 - refined->residual / as_given.residual;
  const Placed chosen = refined ? best_placed(problem, given, as_given, as_started, *refined) : as_given;
  result.camera = chosen.camera;
  result.gain = chosen.gain;
  result.residual = chosen.residual;
  result.corrected = !same_pose(chosen.camera, given);
  result.moved = !same_pose(chosen.camera, start);
  result.moved_px = displacement_px(given, chosen.camera, targets.positions);
  if (options.correlation) result.correlation = correlation(result.camera, result.gain, photograph, targets);
  return result;
}

}  // namespace lumatlas
