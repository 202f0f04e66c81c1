// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: Triggs et al. 2000, "Bundle adjustment", section 6 (normal equations); White 1980 for the deviations.
//
// Letters: q the shared parameters (ln focal, shift x and y in image widths, k1); p a view's own (rotation vector,
// translation in median depths, ln gain); r residuals, J = dr/dp, D = dr/dq.
#include "planner/intrinsics.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mesh/base/median.h"
#include "planner/normal_equations.h"
#include "planner/photometry.h"
#include "planner/requirement.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kFinestPx = 1000;  // longer side: beyond, noise and compression rule the gradients
constexpr std::array<std::uint32_t, 6> kPoseRounds = {1, 0, 0, 0, 0, 0};  // levels above the finest one used
constexpr std::array<std::uint32_t, 18> kRounds = {2, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
constexpr double kRidge = 1e-7;  // of the normal matrix' mean diagonal: for views that nothing else holds
constexpr double kRests = 2e-4;  // a round that changes the residual by less is the last
constexpr double kFixed = 1e6;   // the same, for parameters that stay
// Weak knowledge about lenses: standard deviations of ln focal, shift in widths, and k1.
constexpr double kFocalPrior = 0.1;
constexpr double kShiftPrior = 0.05;
constexpr double kRadialPrior = 0.1;
constexpr double kCountedTwice = 2;
constexpr double kChannels = 3;
constexpr double kLeastImprovement = 0.01;
constexpr double kLeastDeviations = 5;
constexpr double kLeastCornerPx = 0.5;

constexpr int kShared = 4;
constexpr int kPose = 6;
constexpr int kOwn = 7;
using Shared = Eigen::Vector4d;
using Own = Eigen::Matrix<double, kOwn, 1>;
using OwnRows = Eigen::Matrix<double, Eigen::Dynamic, 7>;
using SharedRows = Eigen::Matrix<double, Eigen::Dynamic, 4>;

// Where a camera sees a point, and how that changes.
struct Projection {
  bool inside = false;
  glm::dvec2 image{0.0};
  Eigen::Matrix<double, 2, 4> by_shared = Eigen::Matrix<double, 2, 4>::Zero();
  Eigen::Matrix<double, 2, 6> by_pose = Eigen::Matrix<double, 2, 6>::Zero();
};

Projection project(const Camera& camera, double depth, const Shared& q, const glm::dvec3& position) {
  Projection result;
  const glm::dvec3 cam = camera.cam_from_world(position);
  if (!(cam.z > 0)) return result;
  const double x = cam.x / cam.z;
  const double y = cam.y / cam.z;
  const double r2 = x * x + y * y;
  const double scale = std::exp(q[0]) * (1 + q[3] * r2);
  const double fx = camera.fx * scale;
  const double fy = camera.fy * scale;
  const double width = camera.width;
  result.image = {fx * x + camera.cx + width * q[1], fy * y + camera.cy + width * q[2]};
  result.inside =
      result.image.x >= 0 && result.image.y >= 0 && result.image.x < camera.width && result.image.y < camera.height;
  const double bend = r2 * std::exp(q[0]);
  result.by_shared << fx * x, width, 0, camera.fx * x * bend,  //
      fy * y, 0, width, camera.fy * y * bend;
  // The change of the radial factor with the pose is left out: of second order.
  const double a = fx * depth / cam.z;
  const double b = fy * depth / cam.z;
  result.by_pose << -fx * x * y, fx * (1 + x * x), -fx * y, a, 0, -a * x,  //
      -fy * (1 + y * y), fy * x * y, fy * x, 0, b, -b * y;
  return result;
}

// Another view that shows a point.
struct Observation {
  std::uint32_t slot;
  double level;  // of its pyramid whose pixels are as large on the surface as the own photograph's at level 0
};

struct Point {
  glm::dvec3 position;
  std::vector<Observation> others;
};

// What is fixed about a view,
struct Part {
  std::vector<Point> points;
  double depth = 1;         // median of the points
  std::uint32_t level = 0;  // the finest that is used
};
// and what is refined.
struct State {
  Shared shared = Shared::Zero();
  std::vector<Camera> cameras;  // by slot, with the given intrinsics
  std::vector<double> gain;     // by slot, factor on the view's gain
};

// One term of a target's derivative: d target / d image of the view that gives the median.
struct TargetTerm {
  std::uint32_t slot = 0;
  glm::dvec2 gradient{0.0};
};
struct Linearised {
  Eigen::VectorXd r;
  OwnRows J;
  SharedRows D;                                  // at fixed targets
  std::vector<std::array<TargetTerm, 2>> terms;  // by row: d r / d image, to be subtracted
};

struct Value {
  double color;
  TargetTerm term;
};

// The median and its derivative: that of the value, or the two values, in the middle.
double median_value(std::vector<Value>& values, std::array<TargetTerm, 2>& terms) {
  std::sort(values.begin(), values.end(), [](const Value& a, const Value& b) {
    return a.color != b.color ? a.color < b.color : a.term.slot < b.term.slot;
  });
  const Value& low = values[(values.size() - 1) / 2];
  const Value& high = values[values.size() / 2];
  terms = {low.term, high.term};
  for (TargetTerm& term : terms) term.gradient *= 0.5;
  return 0.5 * (low.color + high.color);
}

Shared prior_weights(const IntrinsicsOptions& options) {
  const double no_radial = 1e-9;
  return Shared(kFocalPrior, kShiftPrior, kShiftPrior, options.radial ? kRadialPrior : no_radial)
      .array()
      .square()
      .inverse();
}

Camera with_intrinsics(Camera camera, const Shared& q) {
  camera.fx *= std::exp(q[0]);
  camera.fy *= std::exp(q[0]);
  camera.cx += q[1] * camera.width;
  camera.cy += q[2] * camera.width;
  return camera;
}

// By how much parameters `q` move the corner of the image that they move most.
double corner_move_px(const Camera& camera, const Shared& q) {
  double most = 0;
  for (int corner = 0; corner < 4; ++corner) {
    const double u = corner & 1 ? camera.width : 0;
    const double v = corner & 2 ? camera.height : 0;
    const double x = (u - camera.cx) / camera.fx;
    const double y = (v - camera.cy) / camera.fy;
    const double scale = std::exp(q[0]) * (1 + q[3] * (x * x + y * y));
    most = std::max(most, std::hypot(camera.fx * x * scale + camera.cx + q[1] * camera.width - u,
                                     camera.fy * y * scale + camera.cy + q[2] * camera.width - v));
  }
  return most;
}

class Estimator {
 public:
  Estimator(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
            std::span<const std::vector<SurfaceSample>> samples, const IntrinsicsOptions& options)
      : views_(views), parts_(views.size()), prior_(prior_weights(options)), options_(options) {
    column_.assign(views.size(), 0);
    for (std::size_t slot = 0; slot < views.size(); ++slot) {
      if (!views[slot]) continue;
      column_[slot] = unknowns_;
      unknowns_ += kOwn;
    }
    state_.cameras.resize(views.size());
    state_.gain.assign(views.size(), 1);
    for (std::size_t slot = 0; slot < views.size(); ++slot) {
      if (views[slot]) state_.cameras[slot] = views[slot]->view->camera;
    }
    tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t slot) {
      if (!views_[slot]) return;
      may_interrupt(options_.interruption_point);
      parts_[slot] = part_of(atlas, static_cast<std::uint32_t>(slot), samples[slot]);
    });
  }

  [[nodiscard]] IntrinsicsEstimate estimate() {
    IntrinsicsEstimate result;
    for (const Part& part : parts_) {
      result.views += !part.points.empty();
      result.points += part.points.size();
    }
    for (const Camera& camera : state_.cameras) {
      if (camera.width > widest_.width) widest_ = camera;
    }
    result.cameras = state_.cameras;
    if (result.views == 0) return result;
    result.unknowns = static_cast<std::size_t>(unknowns_);
    noise_ = noise();
    refine(kPoseRounds, false);
    noise_ = noise();
    refine(kPoseRounds, false);
    result.residual_before = residual_;
    refine(kRounds, true);
    result.residual_after = residual_;
    report(result);
    return result;
  }

 private:
  [[nodiscard]] Part part_of(const Atlas& atlas, std::uint32_t slot, const std::vector<SurfaceSample>& samples) const {
    Part part;
    const Camera& camera = views_[slot]->view->camera;
    const Pyramid& pyramid = views_[slot]->pyramid;
    while (part.level + 1 < pyramid.levels() &&
           std::max(pyramid.level(part.level).width, pyramid.level(part.level).height) > kFinestPx) {
      ++part.level;
    }
    std::vector<double> depths;
    const std::size_t stride = samples.empty() ? 1 : (samples.size() - 1) / options_.most_points + 1;
    for (std::size_t index = 0; index < samples.size(); index += stride) {
      const SurfaceSample& sample = samples[index];
      const double z = camera.cam_from_world(sample.position).z;
      Point point{sample.position, {}};
      for (const std::uint32_t other : atlas.references(atlas.surface().cells.cell_of_face[sample.face])) {
        if (other == slot || !views_[other]) continue;
        const std::optional<glm::dvec3> seen = seen_at(*views_[other]->view, sample.position);
        if (!seen) continue;
        const double pixel_size = z / camera.fx;
        point.others.push_back({other, std::log2(pixel_size * views_[other]->view->camera.fx / seen->z)});
      }
      if (point.others.empty()) continue;
      part.points.push_back(std::move(point));
      depths.push_back(z);
    }
    if (part.points.size() < kFewestAlignmentPoints) return {};
    part.depth = upper_median(depths);
    return part;
  }

  // Rows 3 * index and the next two. `noise` is the residuals' unit.
  void point_rows(const State& state, std::uint32_t slot, std::size_t index, std::uint32_t coarser, bool robust,
                  Linearised& out) const {
    const Part& part = parts_[slot];
    const Point& point = part.points[index];
    const Projection own = project(state.cameras[slot], part.depth, state.shared, point.position);
    const auto first = static_cast<Eigen::Index>(3 * index);
    if (!own.inside) {
      out.r.segment<3>(first).setConstant(tukey(kTukeyCutoff).value);
      return;
    }
    const std::uint32_t level = std::min(part.level + coarser, views_[slot]->pyramid.levels() - 1);
    const ColorSample sample = views_[slot]->pyramid.sample(level, own.image);
    const glm::dvec3 gain = views_[slot]->gain * state.gain[slot];
    std::vector<ColorSample> seen;
    for (const Observation& other : point.others) seen.push_back(sample_of(state, other, level, point.position));
    std::vector<Value> values(seen.size());
    for (int channel = 0; channel < 3; ++channel) {
      for (std::size_t i = 0; i < seen.size(); ++i) {
        values[i] = {seen[i].color[channel],
                     {point.others[i].slot, glm::dvec2(seen[i].d_x[channel], seen[i].d_y[channel])}};
      }
      const Eigen::Index row = first + channel;
      std::array<TargetTerm, 2>& terms = out.terms[static_cast<std::size_t>(row)];
      const double target = median_value(values, terms);
      const double unit = srgb_slope(target) / noise_;
      const double difference = unit * (gain[channel] * sample.color[channel] - target);
      const Robust r = robust ? tukey(difference) : Robust{difference, 1};
      const double slope = r.derivative * unit;
      const Eigen::RowVector2d gradient =
          slope * gain[channel] * Eigen::RowVector2d(sample.d_x[channel], sample.d_y[channel]);
      out.r[row] = r.value;
      out.J.row(row) << gradient * own.by_pose, slope * gain[channel] * sample.color[channel];
      out.D.row(row) = gradient * own.by_shared;
      for (TargetTerm& term : terms) term.gradient *= slope;
    }
  }

  // The other view's colour with its gain.
  [[nodiscard]] ColorSample sample_of(const State& state, const Observation& other, std::uint32_t level,
                                      const glm::dvec3& position) const {
    const ComparedView& view = *views_[other.slot];
    const double matching = std::round(other.level + level);
    const auto its_level = static_cast<std::uint32_t>(std::clamp(matching, 0.0, view.pyramid.levels() - 1.0));
    const Projection at = project(state.cameras[other.slot], parts_[other.slot].depth, state.shared, position);
    ColorSample sample = view.pyramid.sample(its_level, at.image);
    sample.color *= view.gain;
    sample.d_x *= view.gain;
    sample.d_y *= view.gain;
    return sample;
  }

  [[nodiscard]] Linearised linearise(const State& state, std::uint32_t slot, std::uint32_t coarser, bool robust) const {
    const auto rows = static_cast<Eigen::Index>(3 * parts_[slot].points.size());
    Linearised out{Eigen::VectorXd::Zero(rows), OwnRows::Zero(rows, 7), SharedRows::Zero(rows, 4),
                   std::vector<std::array<TargetTerm, 2>>(static_cast<std::size_t>(rows))};
    for (std::size_t index = 0; index < parts_[slot].points.size(); ++index) {
      point_rows(state, slot, index, coarser, robust, out);
    }
    return out;
  }

  [[nodiscard]] std::vector<Linearised> linearise(const State& state, std::uint32_t coarser, bool robust) const {
    std::vector<Linearised> all(parts_.size());
    tbb::parallel_for(std::size_t{0}, parts_.size(), [&](std::size_t slot) {
      if (!views_[slot]) return;
      may_interrupt(options_.interruption_point);
      all[slot] = linearise(state, static_cast<std::uint32_t>(slot), coarser, robust);
    });
    return all;
  }

  // A row of the whole problem's Jacobian: q, the view's own p, and the poses of the views that give the median.
  struct Row {
    static constexpr std::size_t kEntries = kShared + kOwn + 2 * kPose;
    std::array<Eigen::Index, kEntries> column;
    std::array<double, kEntries> value;
  };
  [[nodiscard]] Row row_of(const State& state, std::uint32_t slot, const Linearised& linear, std::size_t index) const {
    Row row;
    const auto at = static_cast<Eigen::Index>(index);
    Eigen::RowVector4d by_shared = linear.D.row(at);
    std::size_t entry = kShared;
    for (int i = 0; i < kOwn; ++i, ++entry) {
      row.column[entry] = column_[slot] + i;
      row.value[entry] = linear.J(at, i);
    }
    for (const TargetTerm& term : linear.terms[index]) {
      const glm::dvec3& position = parts_[slot].points[index / 3].position;
      const Projection seen = project(state.cameras[term.slot], parts_[term.slot].depth, state.shared, position);
      const Eigen::RowVector2d gradient(term.gradient.x, term.gradient.y);
      by_shared -= gradient * seen.by_shared;
      const Eigen::Matrix<double, 1, 6> by_pose = -gradient * seen.by_pose;
      for (int i = 0; i < kPose; ++i, ++entry) {
        row.column[entry] = column_[term.slot] + i;
        row.value[entry] = by_pose[i];
      }
    }
    for (int i = 0; i < kShared; ++i) {
      row.column[static_cast<std::size_t>(i)] = i;
      row.value[static_cast<std::size_t>(i)] = by_shared[i];
    }
    return row;
  }

  // Normal equations of all parameters: q first, then p of every stored view. Of H only the lower triangle is kept.
  struct Normal {
    Eigen::MatrixXd H;
    Eigen::VectorXd g;
  };
  [[nodiscard]] Normal normal_equations(const State& state, const std::vector<Linearised>& all) const {
    Normal normal{Eigen::MatrixXd::Zero(unknowns_, unknowns_), Eigen::VectorXd::Zero(unknowns_)};
    for (std::uint32_t slot = 0; slot < all.size(); ++slot) {
      may_interrupt(options_.interruption_point);
      for (std::size_t index = 0; index < all[slot].terms.size(); ++index) {
        const Row row = row_of(state, slot, all[slot], index);
        const double r = all[slot].r[static_cast<Eigen::Index>(index)];
        for (std::size_t a = 0; a < Row::kEntries; ++a) {
          if (row.value[a] == 0) continue;
          normal.g[row.column[a]] += row.value[a] * r;
          for (std::size_t b = 0; b < Row::kEntries; ++b) {
            if (row.column[b] >= row.column[a]) normal.H(row.column[b], row.column[a]) += row.value[a] * row.value[b];
          }
        }
      }
    }
    const double ridge = kRidge * (normal.H.trace() / static_cast<double>(unknowns_) + 1);
    normal.H.diagonal().array() += ridge;
    normal.H.diagonal().head<kShared>() += prior_;
    normal.g.head<kShared>() += prior_.cwiseProduct(state.shared);
    return normal;
  }

  [[nodiscard]] State stepped(State state, const std::vector<Linearised>& all, bool shared) const {
    Normal normal = normal_equations(state, all);
    if (!shared) normal.H.diagonal().head<kShared>().array() += kFixed * normal.H.trace();
    const Eigen::VectorXd step = -solve_positive_definite(normal.H, normal.g, options_.interruption_point);
    for (std::uint32_t slot = 0; slot < parts_.size(); ++slot) {
      if (!views_[slot]) continue;
      const Own dp = step.segment<kOwn>(column_[slot]);
      const double depth = parts_[slot].depth;
      state.cameras[slot] = moved(state.cameras[slot], {dp[0], dp[1], dp[2]}, depth * glm::dvec3(dp[3], dp[4], dp[5]));
      state.gain[slot] *= std::exp(dp[6]);
    }
    if (shared) state.shared += step.head<kShared>();
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
    for (const Linearised& linear : linearise(state_, 0, false)) {
      for (const double r : linear.r) differences.push_back(std::abs(r));
    }
    return std::max(kSmallestNoise, kDeviationOfMedian * upper_median(differences));
  }

  // Leaves the best state of those at the finest level, the present one among them.
  template <std::size_t Rounds>
  void refine(const std::array<std::uint32_t, Rounds>& rounds, bool shared) {
    State state = state_;
    residual_ = noise_ * root_mean_square(linearise(state, 0, true));
    for (const std::uint32_t coarser : rounds) {
      state = stepped(std::move(state), linearise(state, coarser, true), shared);
      if (coarser > 0) continue;
      const double residual = noise_ * root_mean_square(linearise(state, 0, true));
      const bool rests = residual > (1 - kRests) * residual_ && residual < (1 + kRests) * residual_;
      if (residual < residual_) {
        residual_ = residual;
        state_ = state;
      }
      if (rests) return;
    }
  }

  // Variances of q: see IntrinsicsEstimate::deviation.
  [[nodiscard]] Shared variances() const {
    const std::vector<Linearised> all = linearise(state_, 0, true);
    Eigen::MatrixXd H = normal_equations(state_, all).H;
    // The columns of the inverse that belong to q: all other parameters are marginalised.
    const Eigen::MatrixXd inverse =
        solve_positive_definite(H, Eigen::MatrixXd::Identity(H.rows(), kShared), options_.interruption_point);
    Shared observed = Shared::Zero();
    for (std::uint32_t slot = 0; slot < all.size(); ++slot) {
      may_interrupt(options_.interruption_point);
      Shared pull = Shared::Zero();
      for (std::size_t index = 0; index < all[slot].terms.size(); ++index) {
        const Row row = row_of(state_, slot, all[slot], index);
        const double r = all[slot].r[static_cast<Eigen::Index>(index)];
        for (std::size_t a = 0; a < Row::kEntries; ++a) {
          pull += row.value[a] * r * inverse.row(row.column[a]).transpose();
        }
      }
      observed += pull.cwiseAbs2();
    }
    const double mean_square = std::pow(root_mean_square(all), 2);
    const Shared modelled = kChannels * mean_square * inverse.topRows<kShared>().diagonal();
    return kCountedTwice * modelled.cwiseMax(observed);
  }

  void report(IntrinsicsEstimate& result) {
    const Shared& q = state_.shared;
    const Shared deviation = variances().cwiseSqrt();
    const double width = widest_.width;
    result.correction = {std::exp(q[0]), {width * q[1], width * q[2]}, q[3]};
    result.deviation = {deviation[0], {width * deviation[1], width * deviation[2]}, deviation[3]};
    result.corner_px = corner_move_px(widest_, q);
    for (std::size_t slot = 0; slot < parts_.size(); ++slot) {
      if (views_[slot]) result.cameras[slot] = with_intrinsics(state_.cameras[slot], q);
    }
    if (result.residual_after > (1 - kLeastImprovement) * result.residual_before) return;
    for (int i = 0; i < 4; ++i) {
      Shared alone = Shared::Zero();
      alone[i] = q[i];
      result.significant |=
          std::abs(q[i]) > kLeastDeviations * deviation[i] && corner_move_px(widest_, alone) > kLeastCornerPx;
    }
  }

  std::span<const std::optional<ComparedView>> views_;
  std::vector<Part> parts_;  // by slot; no points: the view is left alone, but others are still compared with it
  Shared prior_;
  IntrinsicsOptions options_;
  std::vector<Eigen::Index> column_;  // by slot: the first that belongs to its view, where there is one
  Eigen::Index unknowns_ = kShared;
  State state_;
  Camera widest_;
  double noise_ = 1;     // of the differences, sRGB
  double residual_ = 0;  // of state_
};

}  // namespace

IntrinsicsEstimate estimate_intrinsics(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
                                       std::span<const std::vector<SurfaceSample>> samples,
                                       const IntrinsicsOptions& options) {
  constexpr Requirement require{"intrinsics"};
  require(options.most_points >= 1, "most_points", 0, "at least 1");
  require.has_size(views.size(), atlas.capacity(), "views", "the atlas's capacity");
  require.has_size(samples.size(), atlas.capacity(), "samples", "the atlas's capacity");
  const std::size_t faces = atlas.surface().cells.cell_of_face.size();
  for (const std::vector<SurfaceSample>& of_view : samples) {
    for (const SurfaceSample& sample : of_view) require.is_below(sample.face, faces, "a sample's face", "the faces");
  }
  return Estimator(atlas, views, samples, options).estimate();
}

}  // namespace lumatlas
