// SPDX-License-Identifier: GPL-3.0-or-later
// A displacement lattice for each stored view (mesh/displacement.h), after Zhou and Koltun 2014: once poses are as good
// as they get, the views' pictures are bent until they agree at surface points. Points' brightnesses and views'
// lattices are solved for in turn, coarse to fine; each lattice is smooth and small, and is kept only where it lowers
// the difference at points that it was not fitted to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mesh/displacement.h"
#include "planner/brightness.h"
#include "planner/interruption.h"

namespace lumatlas {

struct DisplacementOptions {
  std::uint32_t columns = 13, rows = 10;  // of nodes, for pictures that are wider than high; >= 2
  std::uint32_t levels = 3;               // of the pyramid at most, the finest ones, >= 1
  std::uint32_t rounds = 4;               // at each level, >= 1
  std::size_t most_points = 1000;         // of each view, evenly taken, >= 1
  double neighbour_deviation = 0.1;       // prior on how neighbouring nodes differ, pixels of a picture 640 wide, > 0
  double deviation = 0.5;                 // and on the displacements themselves
  double least_improvement = 0.02;        // share of a view's squared difference by which it must fall, [0, 1)
  InterruptionPoint interruption_point = {};
};

struct DisplacementEstimates {
  std::vector<Displacement> of_slot;  // empty: the view's picture stays as it is
  std::uint32_t views = 0;            // that took part
  std::uint32_t displaced = 0;        // whose lattice is kept
  double mean_px = 0;                 // of displacements at points, root of the mean square, displaced views
  // Root of the mean robust squared difference of brightness at points that nothing was fitted to.
  double residual_before = 0, residual_after = 0;
};

// `views` and `samples` by slot, as refine_jointly() takes them, with the same complaints. The same bits for any number
// of threads.
[[nodiscard]] DisplacementEstimates estimate_displacements(const Atlas& atlas,
                                                           std::span<const std::optional<ComparedView>> views,
                                                           std::span<const std::vector<SurfaceSample>> samples,
                                                           const DisplacementOptions& options);

}  // namespace lumatlas
