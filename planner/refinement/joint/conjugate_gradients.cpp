// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/joint/conjugate_gradients.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace lumatlas {

namespace {

constexpr std::size_t kRowsAtOnce = 16;

Eigen::Index first_row(std::size_t block) {
  return static_cast<Eigen::Index>(kBlock * block);
}

// Lists the squares of a symmetric matrix by row, and factors the blocks on its diagonal.
class SymmetricRows {
 public:
  explicit SymmetricRows(const BlockMatrix& matrix) : rows_(matrix.blocks()), diagonal_(matrix.blocks()) {
    for (std::size_t column = 0; column < matrix.blocks(); ++column) {
      for (const auto& [row, square] : matrix.column(column)) {
        if (row == column) continue;
        rows_[row].push_back({static_cast<std::uint32_t>(column), false, &square});
        rows_[column].push_back({row, true, &square});
      }
    }
    for (std::size_t block = 0; block < matrix.blocks(); ++block) set_diagonal(matrix, block);
  }

  [[nodiscard]] Eigen::VectorXd times(const Eigen::VectorXd& x) const {
    Eigen::VectorXd result(x.size());
    for_each_block([&](std::size_t block) {
      Block sum = diagonal_[block].square.selfadjointView<Eigen::Lower>() * x.segment<kBlock>(first_row(block));
      for (const Entry& entry : rows_[block]) {
        const auto part = x.segment<kBlock>(first_row(entry.block));
        if (entry.transposed) {
          sum.noalias() += entry.square->transpose() * part;
        } else {
          sum.noalias() += *entry.square * part;
        }
      }
      result.segment<kBlock>(first_row(block)) = sum;
    });
    return result;
  }

  // Solves for the diagonal of blocks alone.
  [[nodiscard]] Eigen::VectorXd preconditioned(const Eigen::VectorXd& r) const {
    Eigen::VectorXd result(r.size());
    for_each_block([&](std::size_t block) {
      result.segment<kBlock>(first_row(block)) = diagonal_[block].factor.solve(r.segment<kBlock>(first_row(block)));
    });
    return result;
  }

 private:
  struct Entry {
    std::uint32_t block;
    bool transposed;
    const BlockSquare* square;
  };
  struct Diagonal {
    BlockSquare square = BlockSquare::Zero();
    Eigen::LLT<BlockSquare> factor;
  };

  void set_diagonal(const BlockMatrix& matrix, std::size_t block) {
    const auto found = matrix.column(block).find(static_cast<std::uint32_t>(block));
    Diagonal& own = diagonal_[block];
    if (found != matrix.column(block).end()) own.square = found->second;
    own.factor.compute(own.square);
    if (own.factor.info() != Eigen::Success || !own.factor.matrixLLT().diagonal().allFinite()) {
      throw std::domain_error("normal equations: block " + std::to_string(block) + " is not positive definite");
    }
  }

  template <typename Work>
  void for_each_block(const Work& work) const {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rows_.size(), kRowsAtOnce),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        for (std::size_t block = range.begin(); block != range.end(); ++block) work(block);
                      });
  }

  std::vector<std::vector<Entry>> rows_;
  std::vector<Diagonal> diagonal_;
};

}  // namespace

GradientSolution solve_by_gradients(const BlockMatrix& matrix, const Eigen::VectorXd& b, const GradientOptions& options,
                                    const CancelCheck& cancel_check) {
  if (b.size() != first_row(matrix.blocks())) {
    throw std::invalid_argument("normal equations: " + std::to_string(b.size()) + " rows on the right side, must be " +
                                std::to_string(first_row(matrix.blocks())));
  }
  const SymmetricRows rows(matrix);
  GradientSolution result{Eigen::VectorXd::Zero(b.size()), 0, 0};
  Eigen::VectorXd r = b, z = rows.preconditioned(r), p = z;
  double square = r.dot(z);
  const double whole = square;
  while (result.steps < options.most_steps && square > options.least_residual * options.least_residual * whole) {
    check_cancelled(cancel_check);
    const Eigen::VectorXd Ap = rows.times(p);
    const double curvature = p.dot(Ap);
    if (!(curvature > 0)) break;  // rounding is all that is left
    const double length = square / curvature;
    result.x += length * p;
    r -= length * Ap;
    z = rows.preconditioned(r);
    const double next = r.dot(z);
    p = z + next / square * p;
    square = next;
    ++result.steps;
  }
  result.residual = whole > 0 ? std::sqrt(square / whole) : 0;
  return result;
}

}  // namespace lumatlas
