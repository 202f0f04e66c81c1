// SPDX-License-Identifier: GPL-3.0-or-later
// Source: Golub and Van Loan, "Matrix Computations", 4th edition, section 4.2.6 (block outer product Cholesky). Eigen's
// own decompositions cannot be stopped, and at 2000 unknowns its LDLT takes more than a second on one thread.
#include "planner/normal_equations.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <stdexcept>
#include <string>

namespace lumatlas {

namespace {

constexpr Eigen::Index kBlock = 96;  // columns: their update of 6000 rows takes a tenth of a second

// Subtracts the part of a finished block of columns from the columns to its right, each block of those by itself.
void update_trailing(Eigen::MatrixXd& A, Eigen::Index first, Eigen::Index columns,
                     const InterruptionPoint& interruption_point) {
  const Eigen::Index next = first + columns;
  const Eigen::Index blocks = (A.rows() - next + kBlock - 1) / kBlock;
  tbb::parallel_for(Eigen::Index{0}, blocks, [&](Eigen::Index block) {
    may_interrupt(interruption_point);
    const Eigen::Index left = next + block * kBlock;
    const Eigen::Index width = std::min(kBlock, A.rows() - left);
    A.block(left, left, A.rows() - left, width).noalias() -=
        A.block(left, first, A.rows() - left, columns) * A.block(left, first, width, columns).transpose();
  });
}

void factorise(Eigen::MatrixXd& A, const InterruptionPoint& interruption_point) {
  for (Eigen::Index first = 0; first < A.rows(); first += kBlock) {
    may_interrupt(interruption_point);
    const Eigen::Index columns = std::min(kBlock, A.rows() - first);
    const Eigen::Index below = A.rows() - first - columns;
    Eigen::Ref<Eigen::MatrixXd> diagonal = A.block(first, first, columns, columns);
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(diagonal);
    if (llt.info() != Eigen::Success || !diagonal.diagonal().allFinite()) {
      throw std::domain_error("normal equations: the matrix is not positive definite at columns " +
                              std::to_string(first) + " to " + std::to_string(first + columns - 1));
    }
    if (below == 0) return;
    diagonal.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(
        A.block(first + columns, first, below, columns));
    update_trailing(A, first, columns, interruption_point);
  }
}

}  // namespace

Eigen::MatrixXd solve_positive_definite(Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                        const InterruptionPoint& interruption_point) {
  if (A.rows() != A.cols() || A.rows() != B.rows()) {
    throw std::invalid_argument("normal equations: the matrix has " + std::to_string(A.rows()) + " rows and " +
                                std::to_string(A.cols()) + " columns, and the right side " + std::to_string(B.rows()) +
                                " rows, must be as many of each");
  }
  factorise(A, interruption_point);
  Eigen::MatrixXd X = B;
  A.triangularView<Eigen::Lower>().solveInPlace(X);
  A.triangularView<Eigen::Lower>().transpose().solveInPlace(X);
  return X;
}

}  // namespace lumatlas
