// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/exposure_graph.h"

#include <Eigen/Core>
#include <cmath>
#include <utility>

#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

constexpr double kOutlierLog = 0.1;  // ratios off by more than this (a sixth of a stop) lose their say
constexpr double kAnchor = 1e-3;     // e, as a share of a view's own weight of ratios
// Of a system that is solved: the residual, as a share of each slot's diagonal, ln gain. The anchors make an error of
// the solution at most 1 / kAnchor times as large.
constexpr double kTolerance = 1e-9;

constexpr Requirement exposure_graph_requires{"exposure graph"};

struct Edge {
  std::uint32_t from, to;  // ln g_from - ln g_to = log_ratio
  double log_ratio, weight;
};

// Normal equations of the edges, each weighted by how well a solution fits it.
class NormalEquations {
 public:
  // Every edge counts in full without a solution.
  NormalEquations(const std::vector<Edge>& edges, const Eigen::VectorXd* fitted, Eigen::Index slots)
      : edges_(edges), diagonal_(Eigen::VectorXd::Zero(slots)), right_(Eigen::VectorXd::Zero(slots)) {
    weights_.reserve(edges.size());
    for (const Edge& edge : edges) {
      const double misfit =
          fitted == nullptr ? 0 : ((*fitted)[edge.from] - (*fitted)[edge.to] - edge.log_ratio) / kOutlierLog;
      const double weight = edge.weight / (1 + misfit * misfit);
      weights_.push_back(weight);
      for (const std::uint32_t slot : {edge.from, edge.to}) diagonal_[slot] += weight + kAnchor * edge.weight;
      right_[edge.from] += weight * edge.log_ratio;
      right_[edge.to] -= weight * edge.log_ratio;
    }
    for (double& value : diagonal_) value = value > 0 ? value : 1;  // of a slot without ratios, whose gain is 1
  }

  [[nodiscard]] Eigen::VectorXd times(const Eigen::VectorXd& logs) const {
    Eigen::VectorXd product = diagonal_.cwiseProduct(logs);
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      product[edges_[i].from] -= weights_[i] * logs[edges_[i].to];
      product[edges_[i].to] -= weights_[i] * logs[edges_[i].from];
    }
    return product;
  }

  // Conjugate gradients, preconditioned by the diagonal (Shewchuk 1994, B3). Improves `logs` and returns the number of
  // products that it took.
  std::uint64_t solve(Eigen::VectorXd& logs) const {
    Eigen::VectorXd residual = right_ - times(logs);
    Eigen::VectorXd direction = residual.cwiseQuotient(diagonal_);
    Eigen::VectorXd scaled = direction;
    double now = residual.dot(scaled);
    const auto most = static_cast<std::uint64_t>(4 * logs.size() + 20);  // exact arithmetic needs one for each slot
    std::uint64_t products = 1;
    while (scaled.lpNorm<Eigen::Infinity>() > kTolerance && products < most) {
      const Eigen::VectorXd along = times(direction);
      ++products;
      const double step = now / direction.dot(along);
      logs += step * direction;
      residual -= step * along;
      scaled = residual.cwiseQuotient(diagonal_);
      const double next = residual.dot(scaled);
      direction = scaled + (next / now) * direction;
      now = next;
    }
    return products;
  }

 private:
  const std::vector<Edge>& edges_;
  std::vector<double> weights_;
  Eigen::VectorXd diagonal_, right_;
};

// Those of a slot without ratios are 0.
void forget_without_ratios(const std::vector<Edge>& edges, Eigen::VectorXd& logs) {
  Eigen::VectorXd kept = Eigen::VectorXd::Zero(logs.size());
  for (const Edge& edge : edges) {
    for (const std::uint32_t slot : {edge.from, edge.to}) kept[slot] = logs[slot];
  }
  logs = std::move(kept);
}

}  // namespace

ExposureGraph::ExposureGraph(std::uint32_t slots) : ratios_(slots) {}

void ExposureGraph::set(std::uint32_t slot, std::span<const ExposureRatio> ratios) {
  exposure_graph_requires.is_below(slot, ratios_.size(), "slot", "the number of slots");
  for (const ExposureRatio& ratio : ratios) {
    exposure_graph_requires.is_below(ratio.slot, ratios_.size(), "a ratio's slot", "the number of slots");
    for (int channel = 0; channel < 3; ++channel) {
      exposure_graph_requires(std::isfinite(ratio.log_ratio[channel]), "log_ratio", ratio.log_ratio[channel], "finite");
      exposure_graph_requires(std::isfinite(ratio.log_luminance[channel]), "log_luminance",
                              ratio.log_luminance[channel], "finite");
    }
  }
  ratios_[slot].assign(ratios.begin(), ratios.end());
}

void ExposureGraph::erase(std::uint32_t slot) {
  exposure_graph_requires.is_below(slot, ratios_.size(), "slot", "the number of slots");
  ratios_[slot].clear();
  for (std::vector<ExposureRatio>& ratios : ratios_) {
    std::erase_if(ratios, [slot](const ExposureRatio& ratio) { return ratio.slot == slot; });
  }
}

const std::vector<double>& ExposureGraph::log_gains(bool white_balance, int channel) {
  std::vector<Edge> edges;
  for (std::uint32_t slot = 0; slot < ratios_.size(); ++slot) {
    for (const ExposureRatio& ratio : ratios_[slot]) {
      edges.push_back({slot, ratio.slot, (white_balance ? ratio.log_ratio : ratio.log_luminance)[channel],
                       std::sqrt(static_cast<double>(ratio.points))});
    }
  }
  const auto slots = static_cast<Eigen::Index>(ratios_.size());
  Solutions& solutions = solutions_[white_balance ? static_cast<std::size_t>(channel) : 3];
  Eigen::VectorXd logs = Eigen::VectorXd::Zero(slots);  // of the system before
  for (std::size_t system = 0; system < kSystems; ++system) {
    const NormalEquations equations(edges, system == 0 ? nullptr : &logs, slots);
    if (!solutions[system].empty()) logs = Eigen::Map<const Eigen::VectorXd>(solutions[system].data(), slots);
    forget_without_ratios(edges, logs);
    looks_ += edges.size() * equations.solve(logs);
    solutions[system].assign(logs.begin(), logs.end());
  }
  return solutions.back();
}

std::vector<glm::dvec3> ExposureGraph::solve(bool white_balance) {
  std::vector<glm::dvec3> gains(ratios_.size(), glm::dvec3(1.0));
  for (int channel = 0; channel < (white_balance ? 3 : 1); ++channel) {
    const std::vector<double>& logs = log_gains(white_balance, channel);
    for (std::size_t slot = 0; slot < gains.size(); ++slot) {
      const double gain = std::exp(logs[slot]);
      if (white_balance) {
        gains[slot][channel] = gain;
      } else {
        gains[slot] = glm::dvec3(gain);
      }
    }
  }
  return gains;
}

}  // namespace lumatlas
