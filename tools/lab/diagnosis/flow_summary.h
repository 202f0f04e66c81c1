// SPDX-License-Identifier: GPL-3.0-or-later
// Sums up the flows between the photographs of a model: how long they are, which way they go, and what explains them.
#pragma once

#include <cstddef>
#include <vector>

#include "tools/lab/diagnosis/view_flow.h"

namespace lumatlas {

// Medians and 90th percentiles of absolute values, pixels; NaN without flows.
struct FlowSummary {
  std::size_t patches = 0;    // that count
  double counting_share = 0;  // in those that a second view shows
  double length = 0;
  double length_p90 = 0;
  double along = 0;        // the epipolar lines
  double across = 0;       // them
  double along_share = 0;  // of the sum of squares, of all flows
  // Median length of what a move, a turn, a scale and a shear of its photograph do not explain: of each pair of views
  // with at least kFewestOfPair flows, the distance from the affine map of the first photograph that fits best.
  double local = 0;
};

inline constexpr std::size_t kFewestOfPair = 20;

[[nodiscard]] FlowSummary flow_summary(const ViewFlow& flow);

// Returns the summary of each first view's flows, by view slot.
[[nodiscard]] std::vector<FlowSummary> flow_summaries_by_view(const ViewFlow& flow);

}  // namespace lumatlas
