// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/exposure_graph.h"

#include <Eigen/Core>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <cmath>
#include <utility>

#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

constexpr double kOutlierLog = 0.1;  // ratios off by more than this (a sixth of a stop) lose their say
constexpr double kAnchor = 1e-3;     // e, as a share of a view's own weight of ratios
// Residual at which a system counts as solved, as a share of its right side. Small, because the anchors let an error of
// the solution be up to 1 / kAnchor times as large.
constexpr double kTolerance = 1e-11;

constexpr Requirement exposure_graph_requires{"exposure graph"};

// A ratio between two entries of Graph::slots.
struct Edge {
  std::uint32_t from, to;  // ln g_from - ln g_to = log_ratio
  double log_ratio, weight;
};

// The slots that have ratios, in rising order, and the ratios between them. No other slot is part of a system, so that
// the solution is the same to the bit however many slots the store has.
struct Graph {
  std::vector<ViewSlot> slots;
  std::vector<Edge> edges;
};

struct NormalEquations {
  Eigen::SparseMatrix<double> matrix;
  Eigen::VectorXd right;
};

// Weights each edge by how well the solution `fitted` fits it, and fully where there is none.
NormalEquations normal_equations(const Graph& graph, const Eigen::VectorXd* fitted) {
  const auto size = static_cast<Eigen::Index>(graph.slots.size());
  NormalEquations equations{Eigen::SparseMatrix<double>(size, size), Eigen::VectorXd::Zero(size)};
  std::vector<Eigen::Triplet<double>> entries;
  for (const Edge& edge : graph.edges) {
    const auto from = static_cast<int>(edge.from), to = static_cast<int>(edge.to);
    const double misfit = fitted == nullptr ? 0 : ((*fitted)[from] - (*fitted)[to] - edge.log_ratio) / kOutlierLog;
    const double weight = edge.weight / (1 + misfit * misfit);
    for (const int slot : {from, to}) entries.emplace_back(slot, slot, weight + kAnchor * edge.weight);
    entries.emplace_back(from, to, -weight);
    entries.emplace_back(to, from, -weight);
    equations.right[from] += weight * edge.log_ratio;
    equations.right[to] -= weight * edge.log_ratio;
  }
  equations.matrix.setFromTriplets(entries.begin(), entries.end());
  return equations;
}

// Improves `logs` by conjugate gradients, preconditioned by the diagonal. Returns the number of products that it took.
std::uint64_t improve(const NormalEquations& equations, Eigen::VectorXd& logs) {
  Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper> gradients(equations.matrix);
  gradients.setTolerance(kTolerance);
  gradients.setMaxIterations(4 * logs.size() + 20);  // exact arithmetic needs one for each slot
  logs = gradients.solveWithGuess(equations.right, logs).eval();
  return static_cast<std::uint64_t>(gradients.iterations()) + 1;
}

// Replaces the slots that the edges name by their places in graph.slots, which this fills.
void number_slots(Graph& graph, std::size_t slots) {
  std::vector<std::uint32_t> place(slots, 0);
  for (const Edge& edge : graph.edges) place[edge.from] = place[edge.to] = 1;
  for (ViewSlot slot{0}; slot < slots; ++slot) {
    if (place[slot] == 0) continue;
    place[slot] = static_cast<std::uint32_t>(graph.slots.size());
    graph.slots.push_back(slot);
  }
  for (Edge& edge : graph.edges) {
    edge.from = place[edge.from];
    edge.to = place[edge.to];
  }
}

Eigen::VectorXd gathered(const std::vector<double>& by_slot, const std::vector<ViewSlot>& slots) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(slots.size()));
  for (std::size_t i = 0; i < slots.size(); ++i) values[static_cast<Eigen::Index>(i)] = by_slot[slots[i]];
  return values;
}

// 0 for the slots that are not among `slots`.
std::vector<double> scattered(const Eigen::VectorXd& values, const std::vector<ViewSlot>& slots, std::size_t count) {
  std::vector<double> by_slot(count, 0.0);
  for (std::size_t i = 0; i < slots.size(); ++i) by_slot[slots[i]] = values[static_cast<Eigen::Index>(i)];
  return by_slot;
}

}  // namespace

ExposureGraph::ExposureGraph(std::uint32_t slots) : ratios_(slots) {}

void ExposureGraph::set(ViewSlot slot, std::span<const ExposureRatio> ratios) {
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

void ExposureGraph::erase(ViewSlot slot) {
  exposure_graph_requires.is_below(slot, ratios_.size(), "slot", "the number of slots");
  ratios_[slot].clear();
  for (std::vector<ExposureRatio>& ratios : ratios_) {
    std::erase_if(ratios, [slot](const ExposureRatio& ratio) { return ratio.slot == slot; });
  }
}

const std::vector<double>& ExposureGraph::log_gains(bool white_balance, int channel) {
  Graph graph;
  for (ViewSlot slot{0}; slot < ratios_.size(); ++slot) {
    for (const ExposureRatio& ratio : ratios_[slot]) {
      graph.edges.push_back({slot, ratio.slot, (white_balance ? ratio.log_ratio : ratio.log_luminance)[channel],
                             std::sqrt(static_cast<double>(ratio.points))});
    }
  }
  number_slots(graph, ratios_.size());
  Solutions& solutions = solutions_[white_balance ? static_cast<std::size_t>(channel) : 3];
  Eigen::VectorXd logs = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(graph.slots.size()));
  for (std::size_t system = 0; system < kSystems; ++system) {
    const NormalEquations equations = normal_equations(graph, system == 0 ? nullptr : &logs);  // from the system before
    if (!solutions[system].empty()) logs = gathered(solutions[system], graph.slots);
    if (!graph.slots.empty()) looks_ += graph.edges.size() * improve(equations, logs);
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
