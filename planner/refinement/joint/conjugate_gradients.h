// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to planner/: solves normal equations of so many blocks that their factor would take too long.
//
// Preconditioned conjugate gradients (Hestenes and Stiefel 1952; Golub and Van Loan, "Matrix Computations", 4th
// edition, section 11.5). The preconditioner is the diagonal of blocks. A step multiplies each square of the matrix
// once, so that time grows with the number of squares, and memory is that of the matrix.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "mesh/cancel_check.h"
#include "planner/refinement/joint/block_matrix.h"

namespace lumatlas {

struct GradientOptions {
  double least_residual = 1e-6;   // of b, in the preconditioner's norm: a smaller one ends the work; > 0
  std::size_t most_steps = 2000;  // after so many the solution is taken as it is
};

struct GradientSolution {
  Eigen::VectorXd x;
  std::size_t steps = 0;
  double residual = 0;  // of b, in the preconditioner's norm
};

// Solves A x = b for a symmetric positive definite matrix. The same bits for any number of threads. Throws
// std::domain_error if a square on the diagonal is not positive definite or not finite, and std::invalid_argument
// unless b has kBlock * blocks() rows.
[[nodiscard]] GradientSolution solve_by_gradients(const BlockMatrix& matrix, const Eigen::VectorXd& b,
                                                  const GradientOptions& options = {},
                                                  const CancelCheck& cancel_check = {});

}  // namespace lumatlas
