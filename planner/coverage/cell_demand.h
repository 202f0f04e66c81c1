// SPDX-License-Identifier: GPL-3.0-or-later
// The demand for one cell: how large it is in the pictures of the offered views, and from how far they see it.
//
// Held-out views, and people who look at the model, stand where the photographer stood. So a cell that fills the
// picture counts for more than one that never does, and is shown best from the photographer's distance. Both are means
// over the views, not sums: a camera that stands still pulls them towards what it sees, and no further, however long it
// stands.
#pragma once

#include <cstdint>

#include "planner/coverage/coverage.h"

namespace lumatlas {

// Counts in whole numbers, so that it is the same for any order of the views, and taking one back leaves no trace.
class CellDemand {
 public:
  // A view sees the cell. A part that has no distance is not counted. Here and below, throws std::invalid_argument
  // unless the part passes check().
  void add(const Contribution& part) { count(part, 1); }
  // Takes back a view that was added; std::invalid_argument where none is left to be taken back.
  void remove(const Contribution& part) { count(part, -1); }

  // Returns the weight of the cell, in pictures: its mean share of the picture over the views that see it and `prior`
  // more views that do not. `prior` is finite and >= 0 (std::invalid_argument). In [0, 1], 0 if no view sees it.
  [[nodiscard]] double weight(double prior) const;
  // Returns the geometric mean of the distances from which the views see the cell, weighted by their pixels, scene
  // units; 0 if none sees it. It changes in steps of 9 %, so that dependent values must be recomputed less often.
  [[nodiscard]] double ideal_distance() const;

 private:
  void count(const Contribution& part, int sign);

  std::int64_t views_ = 0;
  std::int64_t shares_ = 0;         // sum of picture shares
  std::int64_t log_distances_ = 0;  // sum of log2 of the distances, weighted by these
};

}  // namespace lumatlas
