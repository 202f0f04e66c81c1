// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to planner/: normal equations whose unknowns come in blocks of kBlock, one for each view and each lens. Most
// pairs of views share no point, and their square of the matrix is 0.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "mesh/cancel_check.h"

namespace lumatlas {

// Parameters of a lens, and also of a view (six of its pose and its gain), so that all blocks have one size.
inline constexpr int kBlock = 7;
using Block = Eigen::Matrix<double, kBlock, 1>;
using BlockRows = Eigen::Matrix<double, Eigen::Dynamic, kBlock, Eigen::RowMajor>;
using BlockSquare = Eigen::Matrix<double, kBlock, kBlock>;

// A symmetric matrix of blocks() x blocks() squares. Its lower triangle is kept, without the squares that are 0.
class BlockMatrix {
 public:
  explicit BlockMatrix(std::size_t blocks) : columns_(blocks) {}

  [[nodiscard]] std::size_t blocks() const { return columns_.size(); }
  // The square at `row` and `column`, row >= column; 0 at first. A diagonal square needs its lower triangle alone.
  [[nodiscard]] BlockSquare& at(std::size_t row, std::size_t column) {
    return columns_[column].try_emplace(static_cast<std::uint32_t>(row), BlockSquare::Zero()).first->second;
  }
  // The squares that are kept, by row.
  [[nodiscard]] const std::map<std::uint32_t, BlockSquare>& column(std::size_t column) const {
    return columns_[column];
  }
  [[nodiscard]] double trace() const;

 private:
  std::vector<std::map<std::uint32_t, BlockSquare>> columns_;
};

// The squares that a BlockMatrix may keep: by column, the rows, ascending, each at or below the diagonal.
using BlockPattern = std::vector<std::vector<std::uint32_t>>;

// Returns how many operations on tiles BlockFactor takes at most for a matrix of this pattern, each of some 98^3
// multiplications. Time and memory grow with that number.
[[nodiscard]] std::size_t factor_operations(const BlockPattern& pattern);
// Returns the same number for a dense matrix of `blocks` blocks, which no pattern exceeds.
[[nodiscard]] std::size_t dense_factor_operations(std::size_t blocks);

// The Cholesky factor of a symmetric positive definite matrix. The same bits for any number of threads.
class BlockFactor {
 public:
  // Throws std::domain_error if the matrix is not positive definite or not finite.
  explicit BlockFactor(const BlockMatrix& matrix, const CancelCheck& cancel_check = {});

  // The inverse times B. Throws std::invalid_argument unless B has kBlock * blocks() rows.
  [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& B, const CancelCheck& cancel_check = {}) const;

  // Products of two tiles that it took, each some 98^3 multiplications: what time grows with.
  [[nodiscard]] std::size_t products() const { return products_; }

 private:
  // A column of tiles: its square on the diagonal, above the tiles below that are not 0.
  struct Panel {
    std::vector<std::size_t> rows;  // rows of tiles below the diagonal, ascending
    Eigen::MatrixXd tiles;
  };

  void fill(const BlockMatrix& matrix, const std::vector<std::size_t>& place);
  void factorise(const CancelCheck& cancel_check);
  void update(std::size_t source, std::size_t target);
  [[nodiscard]] Eigen::Index first(std::size_t tile) const;
  [[nodiscard]] Eigen::Index size(std::size_t tile) const;
  [[nodiscard]] Eigen::Index row_in(std::size_t panel, std::size_t tile) const;

  std::vector<std::size_t> order_;  // for each position, the block that stands there
  std::vector<Panel> panels_;
  std::size_t products_ = 0;
};

}  // namespace lumatlas
