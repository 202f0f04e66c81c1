// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: Triggs et al. 2000, "Bundle adjustment", section 6 (normal equations); White 1980 for the deviations.
//
// Letters: q a lens's parameters (ln focal, shift x and y in image widths, k1, k2, p1, p2); p a view's own (rotation
// vector, translation in median depths, ln gain); r residuals, J = dr/dp, D = dr/dq of the view's own lens.
#include "planner/lens_estimate.h"

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
constexpr std::array<std::uint32_t, 6> kMoreRounds = {0, 0, 0, 0, 0, 0};  // once a term has come or gone
constexpr double kFixed = 1e6;       // times the normal matrix' trace: for parameters that stay
constexpr std::size_t kHeldOut = 5;  // each such point is not fitted to
// See LensEstimate::deviation and significant.
constexpr double kCountedTwice = 2;
constexpr double kChannels = 3;
constexpr double kLeastImprovement = 0.01;  // share of the residual
constexpr double kLeastDeviations = 5;
constexpr double kLeastCornerPx = 0.5;

constexpr int kShared = 7;
constexpr int kPose = 6;
constexpr int kOwn = 7;
using Shared = Eigen::Matrix<double, kShared, 1>;
using Own = Eigen::Matrix<double, kOwn, 1>;
using OwnRows = Eigen::Matrix<double, Eigen::Dynamic, kOwn>;
using SharedRows = Eigen::Matrix<double, Eigen::Dynamic, kShared>;

// Which of a lens's parameters are estimated; the others are 0.
using Terms = std::array<bool, kShared>;
constexpr Terms kFirstTerms = {true, true, true, true, false, false, false};
// What is tried then, one after the other.
constexpr std::array<Terms, 2> kMoreTerms = {Terms{false, false, false, false, true, false, false},
                                             Terms{false, false, false, false, false, true, true}};

// Weak knowledge about lenses: standard deviations.
const Shared kPrior = (Shared() << 0.1, 0.05, 0.05, 0.1, 0.1, 0.01, 0.01).finished();

LensCorrection correction_of(const Shared& q) {
  return {std::exp(q[0]), {q[1], q[2]}, q[3], q[4], q[5], q[6]};
}

// Where a camera sees a point, and how that changes.
struct Projection {
  bool inside = false;
  glm::dvec2 image{0.0};
  Eigen::Matrix<double, 2, kShared> by_shared = Eigen::Matrix<double, 2, kShared>::Zero();
  Eigen::Matrix<double, 2, kPose> by_pose = Eigen::Matrix<double, 2, kPose>::Zero();
};

Projection project(const Camera& camera, double depth, const Shared& q, const glm::dvec3& position) {
  Projection result;
  const glm::dvec3 cam = camera.cam_from_world(position);
  if (!(cam.z > 0)) return result;
  result.image = uncorrected(correction_of(q), camera, camera.image_from_cam(cam));
  result.inside =
      result.image.x >= 0 && result.image.y >= 0 && result.image.x < camera.width && result.image.y < camera.height;
  const double x = cam.x / cam.z;
  const double y = cam.y / cam.z;
  const double r2 = x * x + y * y;
  const double width = camera.width;
  const double fx = std::exp(q[0]) * camera.fx;
  const double fy = std::exp(q[0]) * camera.fy;
  result.by_shared <<  //
      result.image.x - camera.cx - width * q[1],
      width, 0, fx * x * r2, fx * x * r2 * r2, fx * 2 * x * y,
      fx * (r2 + 2 * x * x),  //
      result.image.y - camera.cy - width * q[2], 0, width, fy * y * r2, fy * y * r2 * r2, fy * (r2 + 2 * y * y),
      fy * 2 * x * y;
  // The change of the distortion with the pose is left out: of second order.
  const double radial = 1 + r2 * (q[3] + r2 * q[4]);
  const double gx = fx * radial, gy = fy * radial;
  const double a = gx * depth / cam.z;
  const double b = gy * depth / cam.z;
  result.by_pose << -gx * x * y, gx * (1 + x * x), -gx * y, a, 0, -a * x,  //
      -gy * (1 + y * y), gy * x * y, gy * x, 0, b, -b * y;
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
  std::vector<Point> points;    // that are fitted to
  std::vector<Point> held_out;  // by which the fit is judged
  double depth = 1;             // median of the points
  std::uint32_t level = 0;      // the finest that is used
};
// and what is refined.
struct State {
  std::vector<Shared> shared;   // by lens
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

class Estimator {
 public:
  Estimator(const Atlas& atlas, std::span<const std::optional<ComparedView>> views, std::span<const Camera> given,
            std::span<const std::vector<SurfaceSample>> samples, const LensOptions& options)
      : views_(views), given_(given), parts_(views.size()), options_(options) {
    find_lenses();
    unknowns_ = static_cast<Eigen::Index>(kShared * lenses_.size());
    column_.assign(views.size(), 0);
    for (std::size_t slot = 0; slot < views.size(); ++slot) {
      if (!views[slot]) continue;
      column_[slot] = unknowns_;
      unknowns_ += kOwn;
    }
    state_.shared.assign(lenses_.size(), Shared::Zero());
    state_.gain.assign(views.size(), 1);
    terms_.assign(lenses_.size(), kFirstTerms);
    tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t slot) {
      if (!views_[slot]) return;
      may_interrupt(options_.interruption_point);
      parts_[slot] = part_of(atlas, static_cast<std::uint32_t>(slot), samples[slot]);
    });
  }

  [[nodiscard]] LensEstimates estimate() {
    LensEstimates result;
    for (const Part& part : parts_) {
      result.views += !part.points.empty();
      result.points += part.points.size();
    }
    result.lenses = lenses_;
    result.cameras = state_.cameras;
    if (result.views == 0) return result;
    result.unknowns = static_cast<std::size_t>(unknowns_);
    noise_ = noise();
    refine(kPoseRounds, false);
    noise_ = noise();
    refine(kPoseRounds, false);
    const std::vector<double> before = held_out_residuals();
    refine(kRounds, true);
    for (const Terms& more : kMoreTerms) try_terms(more);
    report(before, result);
    return result;
  }

 private:
  // By the cameras of the stored views.
  void find_lenses() {
    state_.cameras.resize(views_.size());
    lens_of_.assign(views_.size(), 0);
    for (std::uint32_t slot = 0; slot < views_.size(); ++slot) {
      if (!views_[slot]) continue;
      const Camera& camera = views_[slot]->view->camera;
      state_.cameras[slot] = camera;
      const auto same = std::find_if(lenses_.begin(), lenses_.end(), [&](const LensEstimate& lens) {
        return share_a_lens(state_.cameras[lens.slots.front()], camera);
      });
      lens_of_[slot] = static_cast<std::size_t>(same - lenses_.begin());
      if (same == lenses_.end()) lenses_.emplace_back();
      lenses_[lens_of_[slot]].slots.push_back(slot);
    }
  }

  [[nodiscard]] const Shared& shared_of(const State& state, std::uint32_t slot) const {
    return state.shared[lens_of_[slot]];
  }

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
      depths.push_back(z);
      const bool held_out = depths.size() % kHeldOut == 0;
      (held_out ? part.held_out : part.points).push_back(std::move(point));
    }
    if (depths.size() < kFewestAlignmentPoints) return {};
    part.depth = upper_median(depths);
    return part;
  }

  // Rows 3 * index and the next two.
  void point_rows(const State& state, std::uint32_t slot, const Point& point, std::size_t index, std::uint32_t coarser,
                  bool robust, Linearised& out) const {
    const Part& part = parts_[slot];
    const Projection own = project(state.cameras[slot], part.depth, shared_of(state, slot), point.position);
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
    const Projection at =
        project(state.cameras[other.slot], parts_[other.slot].depth, shared_of(state, other.slot), position);
    ColorSample sample = view.pyramid.sample(its_level, at.image);
    sample.color *= view.gain;
    sample.d_x *= view.gain;
    sample.d_y *= view.gain;
    return sample;
  }

  [[nodiscard]] Linearised linearise(const State& state, std::uint32_t slot, const std::vector<Point>& points,
                                     std::uint32_t coarser, bool robust) const {
    const auto rows = static_cast<Eigen::Index>(3 * points.size());
    Linearised out{Eigen::VectorXd::Zero(rows), OwnRows::Zero(rows, kOwn), SharedRows::Zero(rows, kShared),
                   std::vector<std::array<TargetTerm, 2>>(static_cast<std::size_t>(rows))};
    for (std::size_t index = 0; index < points.size(); ++index) {
      point_rows(state, slot, points[index], index, coarser, robust, out);
    }
    return out;
  }

  // By slot, of the points that are fitted to or of those held out.
  [[nodiscard]] std::vector<Linearised> linearise(const State& state, std::vector<Point> Part::*points,
                                                  std::uint32_t coarser, bool robust) const {
    std::vector<Linearised> all(parts_.size());
    tbb::parallel_for(std::size_t{0}, parts_.size(), [&](std::size_t slot) {
      if (!views_[slot]) return;
      may_interrupt(options_.interruption_point);
      all[slot] = linearise(state, static_cast<std::uint32_t>(slot), parts_[slot].*points, coarser, robust);
    });
    return all;
  }

  // A row of the whole problem's Jacobian: q of the own lens and of those of the two views that give the median, the
  // view's own p, and the poses of those two. A column may occur more than once.
  struct Row {
    static constexpr std::size_t kEntries = 3 * kShared + kOwn + 2 * kPose;
    std::array<Eigen::Index, kEntries> column;
    std::array<double, kEntries> value;
    std::size_t entries = 0;
    void add(Eigen::Index at, double derivative) {
      if (derivative == 0) return;
      column[entries] = at;
      value[entries++] = derivative;
    }
  };
  [[nodiscard]] Row row_of(const State& state, std::uint32_t slot, const Linearised& linear, std::size_t index) const {
    Row row;
    const auto at = static_cast<Eigen::Index>(index);
    const std::size_t lens = lens_of_[slot];
    Eigen::Matrix<double, 1, kShared> by_own_lens = linear.D.row(at);
    for (int i = 0; i < kOwn; ++i) row.add(column_[slot] + i, linear.J(at, i));
    for (const TargetTerm& term : linear.terms[index]) {
      if (term.gradient == glm::dvec2(0)) continue;
      const glm::dvec3& position = parts_[slot].points[index / 3].position;
      const Projection seen =
          project(state.cameras[term.slot], parts_[term.slot].depth, shared_of(state, term.slot), position);
      const Eigen::RowVector2d gradient(term.gradient.x, term.gradient.y);
      const Eigen::Matrix<double, 1, kShared> by_lens = -gradient * seen.by_shared;
      if (lens_of_[term.slot] == lens) {
        by_own_lens += by_lens;
      } else {
        add_lens(lens_of_[term.slot], by_lens, row);
      }
      const Eigen::Matrix<double, 1, kPose> by_pose = -gradient * seen.by_pose;
      for (int i = 0; i < kPose; ++i) row.add(column_[term.slot] + i, by_pose[i]);
    }
    add_lens(lens, by_own_lens, row);
    return row;
  }

  void add_lens(std::size_t lens, const Eigen::Matrix<double, 1, kShared>& derivatives, Row& row) const {
    for (int i = 0; i < kShared; ++i) {
      if (terms_[lens][static_cast<std::size_t>(i)]) row.add(lens_column(lens) + i, derivatives[i]);
    }
  }
  static Eigen::Index lens_column(std::size_t lens) { return static_cast<Eigen::Index>(kShared * lens); }

  // Normal equations of all parameters: q of every lens first, then p of every stored view. Of H only the lower
  // triangle is kept. What is not estimated has the prior alone, and so stays 0.
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
        for (std::size_t a = 0; a < row.entries; ++a) {
          normal.g[row.column[a]] += row.value[a] * r;
          for (std::size_t b = 0; b < row.entries; ++b) {
            if (row.column[b] >= row.column[a]) normal.H(row.column[b], row.column[a]) += row.value[a] * row.value[b];
          }
        }
      }
    }
    const double ridge = kRidge * (normal.H.trace() / static_cast<double>(unknowns_) + 1);
    normal.H.diagonal().array() += ridge;
    const Shared prior = kPrior.array().square().inverse();
    for (std::size_t lens = 0; lens < lenses_.size(); ++lens) {
      normal.H.diagonal().segment<kShared>(lens_column(lens)) += prior;
      normal.g.segment<kShared>(lens_column(lens)) += prior.cwiseProduct(state.shared[lens]);
    }
    add_pulls(state, normal);
    return normal;
  }

  // As when views are aligned one by one. Without it, a change of the focal length for which all views move along their
  // axes would cost nothing, and whoever draws from the given poses would see the loss.
  void add_pulls(const State& state, Normal& normal) const {
    for (std::uint32_t slot = 0; slot < parts_.size(); ++slot) {
      if (!views_[slot]) continue;
      const double pull = pose_pull(options_.alignment, state.cameras[slot], parts_[slot].points.size());
      const auto [turn, shift] = motion_between(given_[slot], state.cameras[slot]);
      const double depth = parts_[slot].depth;
      Eigen::Matrix<double, kPose, 1> pose;
      pose << turn.x, turn.y, turn.z, shift.x / depth, shift.y / depth, shift.z / depth;
      normal.H.diagonal().segment<kPose>(column_[slot]).array() += pull * pull;
      normal.g.segment<kPose>(column_[slot]) += pull * pull * pose;
    }
  }

  // Without `shared` the lenses stay as they are.
  [[nodiscard]] State stepped(State state, const std::vector<Linearised>& all, bool shared) const {
    Normal normal = normal_equations(state, all);
    const auto first_pose = static_cast<Eigen::Index>(kShared * lenses_.size());
    if (!shared) normal.H.diagonal().head(first_pose).array() += kFixed * normal.H.trace();
    const Eigen::VectorXd step = -solve_positive_definite(normal.H, normal.g, options_.interruption_point);
    for (std::uint32_t slot = 0; slot < parts_.size(); ++slot) {
      if (!views_[slot]) continue;
      const Own dp = step.segment<kOwn>(column_[slot]);
      const double depth = parts_[slot].depth;
      state.cameras[slot] = moved(state.cameras[slot], {dp[0], dp[1], dp[2]}, depth * glm::dvec3(dp[3], dp[4], dp[5]));
      state.gain[slot] *= std::exp(dp[6]);
    }
    for (std::size_t lens = 0; shared && lens < lenses_.size(); ++lens) {
      for (int i = 0; i < kShared; ++i) {
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
    for (const Linearised& linear : linearise(state_, &Part::points, 0, false)) {
      for (const double r : linear.r) differences.push_back(std::abs(r));
    }
    return std::max(kSmallestNoise, kDeviationOfMedian * upper_median(differences));
  }

  // Leaves the best state of those at the finest level, the present one among them.
  template <std::size_t Rounds>
  void refine(const std::array<std::uint32_t, Rounds>& rounds, bool shared) {
    State state = state_;
    residual_ = noise_ * root_mean_square(linearise(state, &Part::points, 0, true));
    for (const std::uint32_t coarser : rounds) {
      state = stepped(std::move(state), linearise(state, &Part::points, coarser, true), shared);
      if (coarser > 0) continue;
      const double residual = noise_ * root_mean_square(linearise(state, &Part::points, 0, true));
      const bool rests = residual > (1 - kRests) * residual_ && residual < (1 + kRests) * residual_;
      if (residual < residual_) {
        residual_ = residual;
        state_ = state;
      }
      if (rests) return;
    }
  }

  // Variances of q by lens: see LensEstimate::deviation.
  [[nodiscard]] std::vector<Shared> variances() const {
    const std::vector<Linearised> all = linearise(state_, &Part::points, 0, true);
    Eigen::MatrixXd H = normal_equations(state_, all).H;
    // The columns of the inverse that belong to q: all other parameters are marginalised.
    const auto columns = static_cast<Eigen::Index>(kShared * lenses_.size());
    const Eigen::MatrixXd inverse =
        solve_positive_definite(H, Eigen::MatrixXd::Identity(H.rows(), columns), options_.interruption_point);
    Eigen::VectorXd observed = Eigen::VectorXd::Zero(columns);
    for (std::uint32_t slot = 0; slot < all.size(); ++slot) {
      may_interrupt(options_.interruption_point);
      Eigen::VectorXd gradient = Eigen::VectorXd::Zero(unknowns_);
      for (std::size_t index = 0; index < all[slot].terms.size(); ++index) {
        const Row row = row_of(state_, slot, all[slot], index);
        const double r = all[slot].r[static_cast<Eigen::Index>(index)];
        for (std::size_t a = 0; a < row.entries; ++a) gradient[row.column[a]] += row.value[a] * r;
      }
      observed += (inverse.transpose() * gradient).cwiseAbs2();
    }
    const double mean_square = std::pow(root_mean_square(all), 2);
    std::vector<Shared> result;
    for (std::size_t lens = 0; lens < lenses_.size(); ++lens) {
      const Eigen::Index first = lens_column(lens);
      const Shared modelled = kChannels * mean_square * inverse.block<kShared, kShared>(first, first).diagonal().eval();
      result.push_back(kCountedTwice * modelled.cwiseMax(observed.segment<kShared>(first)));
    }
    return result;
  }

  // Whether a parameter is more than a few deviations away from 0, and that can be seen.
  [[nodiscard]] bool is_determined(std::size_t lens, int parameter, const Shared& deviation) const {
    Shared alone = Shared::Zero();
    alone[parameter] = state_.shared[lens][parameter];
    return std::abs(alone[parameter]) > kLeastDeviations * deviation[parameter] &&
           corner_move_px(correction_of(alone), camera_of(lens)) > kLeastCornerPx;
  }

  [[nodiscard]] const Camera& camera_of(std::size_t lens) const { return state_.cameras[lenses_[lens].slots.front()]; }

  // Estimates further terms too, and gives them up again for the lenses of which the points do not determine any.
  void try_terms(const Terms& more) {
    const auto set = [&](std::size_t lens, bool estimated) {
      for (int i = 0; i < kShared; ++i) {
        const auto term = static_cast<std::size_t>(i);
        if (!more[term]) continue;
        terms_[lens][term] = estimated;
        if (!estimated) state_.shared[lens][i] = 0;
      }
    };
    const State simpler = state_;
    for (std::size_t lens = 0; lens < lenses_.size(); ++lens) set(lens, true);
    refine(kMoreRounds, true);
    const std::vector<Shared> variance = variances();
    std::size_t given_up = 0;
    for (std::size_t lens = 0; lens < lenses_.size(); ++lens) {
      const Shared deviation = variance[lens].cwiseSqrt();
      bool determined = false;
      for (int i = 0; i < kShared; ++i) {
        determined = determined || (more[static_cast<std::size_t>(i)] && is_determined(lens, i, deviation));
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
    const std::vector<Linearised> all = linearise(state_, &Part::held_out, 0, true);
    std::vector<double> residuals;
    for (const LensEstimate& lens : lenses_) {
      double sum = 0, rows = 0;
      for (const std::uint32_t slot : lens.slots) {
        sum += all[slot].r.squaredNorm();
        rows += static_cast<double>(all[slot].r.size());
      }
      residuals.push_back(rows > 0 ? noise_ * std::sqrt(sum / rows) : 0);
    }
    return residuals;
  }

  void report(const std::vector<double>& before, LensEstimates& result) const {
    result.cameras = state_.cameras;
    const std::vector<Shared> variance = variances();
    const std::vector<double> after = held_out_residuals();
    for (std::size_t lens = 0; lens < lenses_.size(); ++lens) {
      LensEstimate& estimate = result.lenses[lens];
      const auto estimated = [&](int i) { return terms_[lens][static_cast<std::size_t>(i)]; };
      Shared deviation = variance[lens].cwiseSqrt();
      for (int i = 0; i < kShared; ++i) {
        if (!estimated(i)) deviation[i] = 0;
      }
      estimate.correction = correction_of(state_.shared[lens]);
      estimate.deviation = {deviation[0], {deviation[1], deviation[2]}, deviation[3], deviation[4], deviation[5],
                            deviation[6]};
      estimate.residual = {before[lens], after[lens]};
      estimate.corner_px = corner_move_px(estimate.correction, camera_of(lens));
      if (after[lens] > (1 - kLeastImprovement) * before[lens]) continue;
      for (int i = 0; i < kShared; ++i) {
        estimate.significant = estimate.significant || (estimated(i) && is_determined(lens, i, deviation));
      }
    }
  }

  std::span<const std::optional<ComparedView>> views_;
  std::span<const Camera> given_;
  std::vector<Part> parts_;  // by slot; no points: the view is left alone, but others are still compared with it
  LensOptions options_;
  std::vector<LensEstimate> lenses_;  // with their slots, and nothing estimated
  std::vector<std::size_t> lens_of_;  // by slot
  std::vector<Terms> terms_;          // by lens
  std::vector<Eigen::Index> column_;  // by slot: the first that belongs to its view, where there is one
  Eigen::Index unknowns_ = 0;
  State state_;
  double noise_ = 1;     // of the differences, sRGB
  double residual_ = 0;  // of state_
};

}  // namespace

bool LensEstimates::significant() const {
  return std::any_of(lenses.begin(), lenses.end(), [](const LensEstimate& lens) { return lens.significant; });
}

LensEstimates estimate_lenses(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
                              std::span<const Camera> given, std::span<const std::vector<SurfaceSample>> samples,
                              const LensOptions& options) {
  constexpr Requirement require{"lenses"};
  require(options.most_points >= 1, "most_points", 0, "at least 1");
  require.has_size(views.size(), atlas.capacity(), "views", "the atlas's capacity");
  require.has_size(given.size(), atlas.capacity(), "given", "the atlas's capacity");
  require.has_size(samples.size(), atlas.capacity(), "samples", "the atlas's capacity");
  const std::size_t faces = atlas.surface().cells.cell_of_face.size();
  for (const std::vector<SurfaceSample>& of_view : samples) {
    for (const SurfaceSample& sample : of_view) require.is_below(sample.face, faces, "a sample's face", "the faces");
  }
  return Estimator(atlas, views, given, samples, options).estimate();
}

}  // namespace lumatlas
