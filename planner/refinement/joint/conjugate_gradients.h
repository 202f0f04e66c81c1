// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to planner/: solves normal equations by preconditioned conjugate gradients.
//
// Sources: Hestenes and Stiefel 1952; Golub and Van Loan, "Matrix Computations", 4th edition, section 11.5. The
// preconditioner is block Jacobi: it solves each block on the diagonal alone. A step multiplies each square of the
// matrix once, so that time grows with the number of squares. Beside the matrix there are lists of its squares by row.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "mesh/cancel_check.h"
#include "planner/refinement/joint/block_matrix.h"

namespace lumatlas {

// Residuals are |b - A x| over |b|, in the preconditioner's norm.
struct GradientOptions {
  double least_residual = 1e-6;   // residual at which the work ends, > 0
  std::size_t most_steps = 2000;  // number of steps after which it ends in any case
};

struct GradientSolution {
  Eigen::VectorXd x;
  std::size_t steps = 0;
  double residual = 0;
};

// Solves A x = b for a symmetric positive definite matrix. The same bits for any number of threads. Throws
// std::domain_error if a square on the diagonal is not positive definite or not finite, and std::invalid_argument
// unless b has kBlock * blocks() rows.
[[nodiscard]] GradientSolution solve_by_gradients(const BlockMatrix& matrix, const Eigen::VectorXd& b,
                                                  const GradientOptions& options = {},
                                                  const CancelCheck& cancel_check = {});

}  // namespace lumatlas
