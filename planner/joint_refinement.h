// SPDX-License-Identifier: GPL-3.0-or-later
// Poses and gains of all stored views at once, with a colour for each point of the surface that they are compared at:
//
//   min  sum_ij rho((y_j(p_i, T_j) - e^b_j c_i) / noise)  +  pulls        rho: Tukey's biweight; y: brightness.h
//
// over poses T, log gains b and brightnesses c, after Zhou and Koltun 2014. The views are not compared with medians of
// views that are wrong themselves, and none waits for another's turn. Ceres eliminates the c (Schur complement).
// Nothing but weak pulls towards the given poses ties the set to the mesh; whoever uses the result takes back what the
// set has moved as a whole.
// A result that is not better than the given poses by alignment.least_improvement at points held out is not given:
// poses and gains are then what they were.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "planner/alignment.h"
#include "planner/brightness.h"
#include "planner/interruption.h"

namespace lumatlas {

struct JointOptions {
  AlignmentOptions alignment = {};   // its pose, exposure, max_move, prior; levels of the pyramid
  std::size_t most_points = 200;     // of each view, evenly taken, >= 1
  std::uint32_t max_iterations = 8;  // per level, >= 1
  InterruptionPoint interruption_point = {};
};

struct JointRefinement {
  std::uint32_t views = 0;       // that took part; 0: nothing was fitted
  std::size_t points = 0;        // that were fitted to
  std::size_t sights = 0;        // of a point in a view
  std::uint32_t iterations = 0;  // of all levels
  // Root of the mean robust squared difference of brightness at points that nothing was fitted to.
  double residual_before = 0, residual_after = 0;
  std::vector<Camera> cameras;  // by slot; of views that took no part as they were
  std::vector<double> gain;     // by slot: factor on the view's gain; 1 where it took no part
};

// `views`, `given` and `samples` by slot, as estimate_lenses() takes them. The same bits for any number of threads.
// Throws std::invalid_argument if most_points or max_iterations is 0, if there are not as many views, poses and lists
// of samples as the atlas has slots, or if a sample's face is not in the mesh.
[[nodiscard]] JointRefinement refine_jointly(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
                                             std::span<const Camera> given,
                                             std::span<const std::vector<SurfaceSample>> samples,
                                             const JointOptions& options);

}  // namespace lumatlas
