// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/diagnosis/flow_summary.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <utility>

#include "mesh/base/median.h"

namespace lumatlas {

namespace {

constexpr int kRounds = 10;           // of the robust fit
constexpr double kLeastError = 0.05;  // pixels: nearer flows have all the same weight

// Adds the distances of the flows of one pair of views from the affine map that fits best: the sum of distances, by
// weighted squares.
void add_local(std::span<const FlowOfPatch* const> flows, std::vector<double>& distances) {
  using Map = Eigen::Matrix<double, 3, 2>;
  std::vector<double> left(flows.size(), 1.0);
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d squares = 1e-9 * Eigen::Matrix3d::Identity();
    Map right = Map::Zero();
    const auto place = [](const FlowOfPatch& flow) {
      return Eigen::Vector3d(1, flow.image.x / 1000, flow.image.y / 1000);
    };
    const auto move = [](const FlowOfPatch& flow) { return Eigen::RowVector2d(flow.move.x, flow.move.y); };
    for (std::size_t i = 0; i < flows.size(); ++i) {
      const double weight = 1 / std::max(left[i], kLeastError);
      const Eigen::Vector3d at = place(*flows[i]);
      squares += weight * at * at.transpose();
      right += weight * at * move(*flows[i]);
    }
    const Map map = squares.ldlt().solve(right);
    for (std::size_t i = 0; i < flows.size(); ++i) {
      left[i] = (move(*flows[i]) - place(*flows[i]).transpose() * map).norm();
    }
  }
  distances.insert(distances.end(), left.begin(), left.end());
}

double local_flow(std::span<const FlowOfPatch> flows) {
  std::map<std::pair<ViewSlot, ViewSlot>, std::vector<const FlowOfPatch*>> pairs;
  for (const FlowOfPatch& flow : flows) pairs[{flow.first, flow.second}].push_back(&flow);
  std::vector<double> distances;
  for (const auto& [views, of_pair] : pairs) {
    if (of_pair.size() >= kFewestOfPair) add_local(of_pair, distances);
  }
  return distances.empty() ? std::numeric_limits<double>::quiet_NaN() : median(distances);
}

FlowSummary summary_of(std::span<const FlowOfPatch> flows, std::size_t shown) {
  FlowSummary result;
  result.patches = flows.size();
  result.counting_share = shown > 0 ? static_cast<double>(flows.size()) / static_cast<double>(shown) : 0;
  std::vector<double> length, along, across;
  double along_squares = 0, squares = 0;
  for (const FlowOfPatch& flow : flows) {
    along.push_back(std::abs(flow.along));
    across.push_back(std::abs(flow.across));
    length.push_back(std::hypot(flow.along, flow.across));
    along_squares += flow.along * flow.along;
    squares += length.back() * length.back();
  }
  result.length = percentile(length, 0.5);
  result.length_p90 = percentile(length, 0.9);
  result.along = percentile(along, 0.5);
  result.across = percentile(across, 0.5);
  result.along_share = along_squares / squares;  // NaN without flows
  result.local = local_flow(flows);
  return result;
}

}  // namespace

FlowSummary flow_summary(const ViewFlow& flow) {
  return summary_of(flow.flows, flow.shown);
}

std::vector<FlowSummary> flow_summaries_by_view(const ViewFlow& flow) {
  std::vector<FlowSummary> result;
  const FlowOfPatch* next = flow.flows.data();
  const FlowOfPatch* const end = next + flow.flows.size();
  for (std::size_t slot = 0; slot < flow.shown_by_view.size(); ++slot) {
    const FlowOfPatch* const first = next;
    while (next != end && static_cast<std::size_t>(next->first) == slot) ++next;
    result.push_back(summary_of({first, next}, flow.shown_by_view[slot]));
  }
  return result;
}

}  // namespace lumatlas
