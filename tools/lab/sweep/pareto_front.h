// SPDX-License-Identifier: GPL-3.0-or-later
// The Pareto front: choices that no other beats in two figures at once.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace lumatlas {

struct FrontPoint {
  double x = 0, y = 0;
};

// The indices, ascending, of the points that no other is at least as good as in both and better in one; equal points
// stand or fall together. Points that are not finite are on no front and beat nothing.
[[nodiscard]] std::vector<std::size_t> pareto_front(std::span<const FrontPoint> points, bool more_x_is_better,
                                                    bool more_y_is_better);

}  // namespace lumatlas
