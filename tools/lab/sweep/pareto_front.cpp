// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/sweep/pareto_front.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lumatlas {

namespace {

struct Cost {
  double x, y;  // less is better
  std::size_t index;
};

}  // namespace

std::vector<std::size_t> pareto_front(std::span<const FrontPoint> points, bool more_x_is_better,
                                      bool more_y_is_better) {
  std::vector<Cost> costs;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!std::isfinite(points[i].x) || !std::isfinite(points[i].y)) continue;
    costs.push_back({more_x_is_better ? -points[i].x : points[i].x, more_y_is_better ? -points[i].y : points[i].y, i});
  }
  std::sort(costs.begin(), costs.end(),
            [](const Cost& a, const Cost& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  std::vector<std::size_t> front;
  double best_y = std::numeric_limits<double>::infinity();  // of the points before
  double best_x = 0;                                        // where best_y was reached
  for (const Cost& cost : costs) {
    const bool equals_last = !front.empty() && cost.y == best_y && cost.x == best_x;
    if (!(cost.y < best_y) && !equals_last) continue;
    best_x = cost.x;
    best_y = cost.y;
    front.push_back(cost.index);
  }
  std::sort(front.begin(), front.end());
  return front;
}

}  // namespace lumatlas
