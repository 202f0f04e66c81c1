// SPDX-License-Identifier: GPL-3.0-or-later
// Solves dense normal equations of thousands of unknowns, which takes seconds, so that a caller can stop it.
#pragma once

#include <Eigen/Core>

#include "planner/interruption.h"

namespace lumatlas {

// A^-1 B of a symmetric positive definite A, of which the lower triangle is read; A is overwritten by its Cholesky
// factor. The same bits for any number of threads. Throws std::invalid_argument if the sizes do not fit, and
// std::domain_error, naming the column, if A is not positive definite or not finite.
[[nodiscard]] Eigen::MatrixXd solve_positive_definite(Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                                      const InterruptionPoint& interruption_point = {});

}  // namespace lumatlas
