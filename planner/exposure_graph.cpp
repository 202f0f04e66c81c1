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

// A ratio between two entries of Graph::slots.
struct Edge {
  std::uint32_t from, to;  // ln g_from - ln g_to = log_ratio
  double log_ratio, weight;
};

// The slots that have ratios, in rising order, and the ratios between them. No other slot is part of a system, so that
// the solution is the same to the bit however many slots the store has.
struct Graph {
  std::vector<std::uint32_t> slots;
  std::vector<Edge> edges;
};

// Normal equations of the edges, each weighted by how well a solution fits it.
class NormalEquations {
 public:
  // Every edge counts in full without a solution.
  NormalEquations(const Graph& graph, const Eigen::VectorXd* fitted)
      : edges_(graph.edges),
        diagonal_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(graph.slots.size()))),
        right_(Eigen::VectorXd::Zero(diagonal_.size())) {
    weights_.reserve(edges_.size());
    for (const Edge& edge : edges_) {
      const double misfit =
          fitted == nullptr ? 0 : ((*fitted)[edge.from] - (*fitted)[edge.to] - edge.log_ratio) / kOutlierLog;
      const double weight = edge.weight / (1 + misfit * misfit);
      weights_.push_back(weight);
      for (const std::uint32_t slot : {edge.from, edge.to}) diagonal_[slot] += weight + kAnchor * edge.weight;
      right_[edge.from] += weight * edge.log_ratio;
      right_[edge.to] -= weight * edge.log_ratio;
    }
    for (double& value : diagonal_) value = value > 0 ? value : 1;  // of a slot whose ratios are of no point at all
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
  const std::vector<Edge>& edges_;  // of a graph that outlives this
  std::vector<double> weights_;
  Eigen::VectorXd diagonal_, right_;
};

// Replaces the slots that the edges name by their places in graph.slots, which this fills.
void number_slots(Graph& graph, std::size_t slots) {
  std::vector<std::uint32_t> place(slots, 0);
  for (const Edge& edge : graph.edges) place[edge.from] = place[edge.to] = 1;
  for (std::uint32_t slot = 0; slot < slots; ++slot) {
    if (place[slot] == 0) continue;
    place[slot] = static_cast<std::uint32_t>(graph.slots.size());
    graph.slots.push_back(slot);
  }
  for (Edge& edge : graph.edges) {
    edge.from = place[edge.from];
    edge.to = place[edge.to];
  }
}

Eigen::VectorXd gathered(const std::vector<double>& by_slot, const std::vector<std::uint32_t>& slots) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(slots.size()));
  for (std::size_t i = 0; i < slots.size(); ++i) values[static_cast<Eigen::Index>(i)] = by_slot[slots[i]];
  return values;
}

// 0 for the slots that are not among `slots`.
std::vector<double> scattered(const Eigen::VectorXd& values, const std::vector<std::uint32_t>& slots,
                              std::size_t count) {
  std::vector<double> by_slot(count, 0.0);
  for (std::size_t i = 0; i < slots.size(); ++i) by_slot[slots[i]] = values[static_cast<Eigen::Index>(i)];
  return by_slot;
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
  Graph graph;
  for (std::uint32_t slot = 0; slot < ratios_.size(); ++slot) {
    for (const ExposureRatio& ratio : ratios_[slot]) {
      graph.edges.push_back({slot, ratio.slot, (white_balance ? ratio.log_ratio : ratio.log_luminance)[channel],
                             std::sqrt(static_cast<double>(ratio.points))});
    }
  }
  number_slots(graph, ratios_.size());
  Solutions& solutions = solutions_[white_balance ? static_cast<std::size_t>(channel) : 3];
  Eigen::VectorXd logs = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(graph.slots.size()));
  for (std::size_t system = 0; system < kSystems; ++system) {
    const NormalEquations equations(graph, system == 0 ? nullptr : &logs);  // logs: of the system before
    if (!solutions[system].empty()) logs = gathered(solutions[system], graph.slots);
    if (!graph.slots.empty()) looks_ += graph.edges.size() * equations.solve(logs);
    solutions[system] = scattered(logs, graph.slots, ratios_.size());
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
