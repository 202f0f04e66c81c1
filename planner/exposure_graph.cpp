// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/exposure_graph.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cmath>
#include <limits>

#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

constexpr int kReweightings = 4;
constexpr double kOutlierLog = 0.1;  // ratios off by more than this (a sixth of a stop) lose their say
constexpr double kAnchor = 1e-3;     // e, as a share of a view's own weight of ratios

constexpr Requirement exposure_graph_requires{"exposure graph"};

struct Edge {
  std::uint32_t from, to;  // ln g_from - ln g_to = log_ratio
  double log_ratio, weight;
};

// Normal equations of the edges, each weighted by how well the last solution fits it.
Eigen::VectorXd solve_once(const std::vector<Edge>& edges, const Eigen::VectorXd& last, double outlier, int slots) {
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(slots);
  for (const Edge& edge : edges) {
    const auto i = static_cast<int>(edge.from);
    const auto j = static_cast<int>(edge.to);
    const double misfit = (last[i] - last[j] - edge.log_ratio) / outlier;
    const double weight = edge.weight / (1 + misfit * misfit);
    const double anchor = kAnchor * edge.weight;
    entries.insert(entries.end(), {{i, i, weight + anchor}, {j, j, weight + anchor}, {i, j, -weight}, {j, i, -weight}});
    right[i] += weight * edge.log_ratio;
    right[j] -= weight * edge.log_ratio;
  }
  for (int slot = 0; slot < slots; ++slot) entries.emplace_back(slot, slot, 1e-9);
  Eigen::SparseMatrix<double> matrix(slots, slots);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(right);
}

Eigen::VectorXd log_gains(const std::vector<Edge>& edges, int slots) {
  // Without a solution yet, every edge counts in full.
  Eigen::VectorXd gains =
      solve_once(edges, Eigen::VectorXd::Zero(slots), std::numeric_limits<double>::infinity(), slots);
  for (int round = 0; round < kReweightings; ++round) gains = solve_once(edges, gains, kOutlierLog, slots);
  return gains;
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

std::vector<glm::dvec3> ExposureGraph::solve(bool white_balance) const {
  std::vector<glm::dvec3> gains(ratios_.size(), glm::dvec3(1.0));
  for (int channel = 0; channel < (white_balance ? 3 : 1); ++channel) {
    std::vector<Edge> edges;
    for (std::uint32_t slot = 0; slot < ratios_.size(); ++slot) {
      for (const ExposureRatio& ratio : ratios_[slot]) {
        edges.push_back({slot, ratio.slot, (white_balance ? ratio.log_ratio : ratio.log_luminance)[channel],
                         std::sqrt(static_cast<double>(ratio.points))});
      }
    }
    const Eigen::VectorXd logs = log_gains(edges, static_cast<int>(ratios_.size()));
    for (std::size_t slot = 0; slot < gains.size(); ++slot) {
      const double gain = std::exp(logs[static_cast<Eigen::Index>(slot)]);
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
