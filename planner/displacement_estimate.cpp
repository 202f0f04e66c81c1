// SPDX-License-Identifier: GPL-3.0-or-later
// Source: Zhou and Koltun 2014, "Color map optimization for 3D reconstruction with consumer depth cameras", section 5.
#include "planner/displacement_estimate.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "mesh/base/median.h"
#include "planner/photometry.h"
#include "planner/requirement.h"

namespace lumatlas {

namespace {

constexpr double kUsualWidth = 640;  // pixels: the priors are given for it
constexpr std::size_t kPointsPerTask = 256;

// A point in a view: where it is in the picture, and what is found there.
struct Place {
  std::uint32_t slot;
  float level;
  glm::dvec2 image;
};
struct Places {
  std::vector<std::size_t> first = {0};  // by point
  std::vector<Place> places;
  std::vector<std::vector<std::size_t>> of_slot;  // indices of places
};

Places places_of(const SeenPoints& points, std::span<const std::optional<ComparedView>> views) {
  Places result;
  result.of_slot.resize(views.size());
  for (std::size_t point = 0; point < points.positions.size(); ++point) {
    for (std::size_t i = points.first[point]; i < points.first[point + 1]; ++i) {
      const Sight& sight = points.sights[i];
      const Camera& camera = views[sight.slot]->view->camera;
      const glm::dvec3 cam = camera.cam_from_world(points.positions[point]);
      if (!(cam.z > 0)) continue;
      result.of_slot[sight.slot].push_back(result.places.size());
      result.places.push_back({sight.slot, sight.level, camera.image_from_cam(cam)});
    }
    result.first.push_back(result.places.size());
  }
  return result;
}

class DisplacementSolver {
 public:
  DisplacementSolver(std::span<const std::optional<ComparedView>> views, const PointSplit& split,
                     const DisplacementOptions& options)
      : views_(views),
        options_(options),
        fitted_(places_of(split.fitted, views)),
        held_out_(places_of(split.held_out, views)),
        lattices_(views.size()) {
    for (std::size_t slot = 0; slot < views.size(); ++slot) {
      if (views[slot] && split.depth[slot] > 0) lattices_[slot] = no_displacement(views[slot]->view->camera);
    }
  }

  [[nodiscard]] DisplacementEstimates estimate() {
    DisplacementEstimates result;
    result.of_slot.resize(views_.size());
    for (const Displacement& lattice : lattices_) result.views += !lattice.empty();
    if (result.views == 0) return result;
    const std::vector<Displacement> none(lattices_.size());
    for (std::uint32_t coarser = options_.levels; coarser-- > 0;) {
      for (std::uint32_t round = 0; round < options_.rounds; ++round) step(coarser);
    }
    look(fitted_, lattices_, 0);
    agree(fitted_);
    noise_ = noise();
    const std::vector<double> before = squares(none);
    keep_what_helps(before, squares(lattices_));
    // Lattices that were given up have changed what the others are compared with.
    const std::vector<double> after = squares(lattices_);
    keep_what_helps(before, after);
    report(before, squares(lattices_), result);
    return result;
  }

 private:
  [[nodiscard]] Displacement no_displacement(const Camera& camera) const {
    const bool upright = camera.height > camera.width;
    const std::uint32_t columns = upright ? options_.rows : options_.columns;
    const std::uint32_t rows = upright ? options_.columns : options_.rows;
    return {columns, rows, std::vector<glm::dvec2>(std::size_t{columns} * rows, glm::dvec2(0))};
  }

  void look(const Places& places, const std::vector<Displacement>& lattices, std::uint32_t coarser) {
    seen_.resize(places.places.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, places.places.size(), kPointsPerTask), [&](const auto& range) {
      may_interrupt(options_.interruption_point);
      for (std::size_t i = range.begin(); i != range.end(); ++i) {
        const Place& place = places.places[i];
        const ComparedView& view = *views_[place.slot];
        const glm::dvec2 moved = place.image + lattices[place.slot].at(view.view->camera, place.image);
        seen_[i] = brightness_in(view, static_cast<double>(place.level) + coarser, moved);
      }
    });
  }

  // The brightness of each point, from what the views show of it.
  void agree(const Places& places) {
    brightness_.assign(places.first.size() - 1, 0);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, brightness_.size(), kPointsPerTask), [&](const auto& range) {
      std::vector<double> values;
      for (std::size_t point = range.begin(); point != range.end(); ++point) {
        values.clear();
        for (std::size_t i = places.first[point]; i < places.first[point + 1]; ++i) {
          if (seen_[i].inside) values.push_back(seen_[i].value);
        }
        if (!values.empty()) brightness_[point] = noise_ > 0 ? robust_mean(values, noise_) : median(values);
      }
    });
    difference_.resize(places.places.size());
    for (std::size_t point = 0; point < brightness_.size(); ++point) {
      for (std::size_t i = places.first[point]; i < places.first[point + 1]; ++i) {
        difference_[i] = seen_[i].inside ? seen_[i].value - brightness_[point] : 0;
      }
    }
  }

  [[nodiscard]] double noise() const {
    std::vector<double> all;
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      if (seen_[i].inside) all.push_back(std::abs(difference_[i]));
    }
    return all.empty() ? kSmallestNoise : std::max(kSmallestNoise, kDeviationOfMedian * upper_median(all));
  }

  // Brightnesses, and then one step of each lattice.
  void step(std::uint32_t coarser) {
    look(fitted_, lattices_, coarser);
    noise_ = 0;
    agree(fitted_);
    noise_ = noise();
    agree(fitted_);
    tbb::parallel_for(std::size_t{0}, lattices_.size(), [&](std::size_t slot) {
      if (lattices_[slot].empty()) return;
      may_interrupt(options_.interruption_point);
      step_view(slot);
    });
  }

  void step_view(std::size_t slot) {
    Displacement& lattice = lattices_[slot];
    const Camera& camera = views_[slot]->view->camera;
    const auto unknowns = static_cast<Eigen::Index>(2 * lattice.nodes.size());
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(unknowns, unknowns);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(unknowns);
    for (const std::size_t i : fitted_.of_slot[slot]) {
      if (!seen_[i].inside) continue;
      const Robust robust = tukey(difference_[i] / noise_);
      if (robust.derivative == 0) continue;
      const LatticeShares shares = lattice_shares(lattice.columns, lattice.rows, camera, fitted_.places[i].image);
      add_row(shares, robust.derivative / noise_ * seen_[i].by_image, robust.value, H, g);
    }
    add_prior(lattice, camera, H, g);
    const Eigen::VectorXd change = H.selfadjointView<Eigen::Lower>().llt().solve(-g);
    for (std::size_t node = 0; node < lattice.nodes.size(); ++node) {
      const auto at = static_cast<Eigen::Index>(2 * node);
      lattice.nodes[node] += glm::dvec2(change[at], change[at + 1]);
    }
  }

  // Of H the lower triangle.
  static void add_row(const LatticeShares& shares, const glm::dvec2& by_image, double r, Eigen::MatrixXd& H,
                      Eigen::VectorXd& g) {
    std::array<double, 8> value;
    std::array<Eigen::Index, 8> column;
    for (std::size_t i = 0; i < 4; ++i) {
      value[2 * i] = shares.share[i] * by_image.x;
      value[2 * i + 1] = shares.share[i] * by_image.y;
      column[2 * i] = static_cast<Eigen::Index>(2 * shares.node[i]);
      column[2 * i + 1] = column[2 * i] + 1;
    }
    for (std::size_t a = 0; a < 8; ++a) {
      g[column[a]] += value[a] * r;
      for (std::size_t b = 0; b <= a; ++b) H(column[a], column[b]) += value[a] * value[b];
    }
  }

  void add_prior(const Displacement& lattice, const Camera& camera, Eigen::MatrixXd& H, Eigen::VectorXd& g) const {
    const double unit = kUsualWidth / std::max(camera.width, camera.height);
    const double small = std::pow(unit / options_.deviation, 2);
    const double smooth = std::pow(unit / options_.neighbour_deviation, 2);
    const auto add = [&](std::size_t a, std::size_t b) {
      for (int axis = 0; axis < 2; ++axis) {
        const auto low = static_cast<Eigen::Index>(2 * a) + axis;
        const auto high = static_cast<Eigen::Index>(2 * b) + axis;
        const double difference = lattice.nodes[b][axis] - lattice.nodes[a][axis];
        H(low, low) += smooth;
        H(high, high) += smooth;
        H(high, low) -= smooth;
        g[high] += smooth * difference;
        g[low] -= smooth * difference;
      }
    };
    for (std::size_t row = 0; row < lattice.rows; ++row) {
      for (std::size_t column = 0; column < lattice.columns; ++column) {
        const std::size_t node = row * lattice.columns + column;
        if (column + 1 < lattice.columns) add(node, node + 1);
        if (row + 1 < lattice.rows) add(node, node + lattice.columns);
        for (int axis = 0; axis < 2; ++axis) {
          const auto at = static_cast<Eigen::Index>(2 * node) + axis;
          H(at, at) += small;
          g[at] += small * lattice.nodes[node][axis];
        }
      }
    }
  }

  // By slot, of the view's differences at points held out.
  [[nodiscard]] std::vector<double> squares(const std::vector<Displacement>& lattices) {
    look(held_out_, lattices, 0);
    agree(held_out_);
    std::vector<double> sums(views_.size(), 0);
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      const double r = seen_[i].inside ? difference_[i] / noise_ : kTukeyCutoff;
      sums[held_out_.places[i].slot] += std::pow(tukey(r).value, 2);
    }
    return sums;
  }

  void keep_what_helps(const std::vector<double>& before, const std::vector<double>& after) {
    for (std::size_t slot = 0; slot < lattices_.size(); ++slot) {
      if (!(after[slot] < (1 - options_.least_improvement) * before[slot])) lattices_[slot] = {};
    }
  }

  void report(const std::vector<double>& before, const std::vector<double>& after,
              DisplacementEstimates& result) const {
    double sum_before = 0, sum_after = 0;
    for (std::size_t slot = 0; slot < views_.size(); ++slot) {
      sum_before += before[slot];
      sum_after += after[slot];
    }
    const auto places = static_cast<double>(std::max<std::size_t>(held_out_.places.size(), 1));
    result.residual_before = noise_ * std::sqrt(sum_before / places);
    result.residual_after = noise_ * std::sqrt(sum_after / places);
    double square = 0;
    std::size_t moved = 0;
    for (const Place& place : held_out_.places) {
      const Displacement& lattice = lattices_[place.slot];
      if (lattice.empty()) continue;
      const glm::dvec2 by = lattice.at(views_[place.slot]->view->camera, place.image);
      square += by.x * by.x + by.y * by.y;
      ++moved;
    }
    if (moved > 0) result.mean_px = std::sqrt(square / static_cast<double>(moved));
    for (const Displacement& lattice : lattices_) result.displaced += !lattice.empty();
    result.of_slot = lattices_;
  }

  std::span<const std::optional<ComparedView>> views_;
  const DisplacementOptions& options_;
  Places fitted_, held_out_;
  std::vector<Displacement> lattices_;  // by slot; empty: not displaced
  double noise_ = 0;                    // of the differences; 0: not known yet
  std::vector<Brightness> seen_;        // by place
  std::vector<double> difference_;      // by place
  std::vector<double> brightness_;      // by point
};

}  // namespace

DisplacementEstimates estimate_displacements(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
                                             std::span<const std::vector<SurfaceSample>> samples,
                                             const DisplacementOptions& options) {
  constexpr Requirement require{"displacements"};
  require(options.columns >= 2, "columns", options.columns, "at least 2");
  require(options.rows >= 2, "rows", options.rows, "at least 2");
  require(options.levels >= 1, "levels", options.levels, "at least 1");
  require(options.rounds >= 1, "rounds", options.rounds, "at least 1");
  require(options.most_points >= 1, "most_points", 0, "at least 1");
  require(options.neighbour_deviation > 0, "neighbour_deviation", options.neighbour_deviation, "positive");
  require(options.deviation > 0, "deviation", options.deviation, "positive");
  require(options.least_improvement >= 0 && options.least_improvement < 1, "least_improvement",
          options.least_improvement, "in [0, 1)");
  require.has_size(views.size(), atlas.capacity(), "views", "the atlas's capacity");
  require.has_size(samples.size(), atlas.capacity(), "samples", "the atlas's capacity");
  const std::size_t faces = atlas.surface().cells.cell_of_face.size();
  for (const std::vector<SurfaceSample>& of_view : samples) {
    for (const SurfaceSample& sample : of_view) require.is_below(sample.face, faces, "a sample's face", "the faces");
  }
  const PointSplit split = split_points(atlas, views, samples, options.most_points);
  return DisplacementSolver(views, split, options).estimate();
}

}  // namespace lumatlas
