// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to planner/: the normal equations of all lenses, poses and exposures, from a linearised JointProblem.
// Source: Triggs et al. 2000, "Bundle adjustment", section 6.
//
// The unknowns are blocks of kBlock: q of every lens first, then p of every view, and m of every view where motions are
// estimated.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "mesh/cancel_check.h"
#include "planner/refinement/joint/block_matrix.h"
#include "planner/refinement/joint/joint_problem.h"

namespace lumatlas {

// Half of the gradient of one view's squared residuals: the blocks in which it is not 0, ascending.
struct ViewGradient {
  std::vector<std::size_t> blocks;
  std::vector<Block> values;
};

// The numbers of the blocks of a view, by view slot.
struct ViewBlocks {
  std::vector<std::size_t> own;     // of p, where there is a view
  std::vector<std::size_t> motion;  // of m; empty: motions are not estimated
};

struct JointEquations {
  BlockMatrix H;
  Eigen::VectorXd g;
  std::vector<ViewGradient> of_views;  // one per view slot
};

// Returns the squares of the equations that may not be 0, whichever of the views that show a point its medians are of.
[[nodiscard]] BlockPattern joint_pattern(const JointProblem& problem, std::size_t blocks, const ViewBlocks& block_of,
                                         const CancelCheck& cancel_check);

// `estimated` by lens: 1 for each parameter that is, 0 for the others, whose rows and columns are 0 then. `blocks`: how
// many there are. The same bits for any number of threads.
[[nodiscard]] JointEquations joint_equations(const JointProblem& problem, const JointState& state,
                                             const std::vector<Linearised>& linear, std::span<const Block> estimated,
                                             std::size_t blocks, const ViewBlocks& block_of,
                                             const CancelCheck& cancel_check);

}  // namespace lumatlas
