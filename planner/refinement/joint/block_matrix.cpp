// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: Golub and Van Loan, "Matrix Computations", 4th edition, section 4.2.6 (block outer product Cholesky); Davis,
// "Direct Methods for Sparse Linear Systems", chapters 4 and 7 (elimination trees; approximate minimum degree).
//
// Blocks are put into an order that keeps the factor sparse, and then taken together in tiles, so that nearly all time
// is spent in products of dense tiles: where all pairs of views share points, this is dense Cholesky decomposition.
// Eigen's own sparse decompositions cannot be stopped, and take one thread.
#include "planner/refinement/joint/block_matrix.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>

namespace lumatlas {

namespace {

constexpr std::size_t kTileBlocks = 14;  // 98 columns: the update of 6000 rows by them takes a tenth of a second
constexpr Eigen::Index kTile = static_cast<Eigen::Index>(kTileBlocks) * kBlock;

std::size_t tiles_for(std::size_t blocks) {
  return (blocks + kTileBlocks - 1) / kTileBlocks;
}

BlockPattern pattern_of(const BlockMatrix& matrix) {
  BlockPattern pattern(matrix.blocks());
  for (std::size_t column = 0; column < matrix.blocks(); ++column) {
    for (const auto& [row, square] : matrix.column(column)) pattern[column].push_back(row);
  }
  return pattern;
}

// Returns the blocks in an order that keeps the factor sparse.
std::vector<std::size_t> sparse_order(const BlockPattern& squares) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t column = 0; column < squares.size(); ++column) {
    for (const std::uint32_t row : squares[column]) {
      entries.emplace_back(static_cast<int>(row), static_cast<int>(column), 1.0);
      entries.emplace_back(static_cast<int>(column), static_cast<int>(row), 1.0);
    }
  }
  const auto size = static_cast<Eigen::Index>(squares.size());
  Eigen::SparseMatrix<double> pattern(size, size);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::AMDOrdering<int>::PermutationType permutation;
  Eigen::AMDOrdering<int>()(pattern, permutation);
  std::vector<std::size_t> order;
  for (const int block : permutation.indices()) order.push_back(static_cast<std::size_t>(block));
  return order;
}

std::vector<std::size_t> places_of(const std::vector<std::size_t>& order) {
  std::vector<std::size_t> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = i;
  return place;
}

// Returns for each column of tiles which tiles of the factor below the diagonal are not 0, ascending: those of the
// matrix, and those that each column hands on to its parent in the elimination tree, the column of its first tile below
// the diagonal. A parent comes after its children.
std::vector<std::vector<std::size_t>> tile_rows(const BlockPattern& squares, const std::vector<std::size_t>& place) {
  std::vector<std::vector<std::size_t>> all(tiles_for(squares.size()));
  for (std::size_t column = 0; column < squares.size(); ++column) {
    for (const std::uint32_t row : squares[column]) {
      const std::size_t a = place[column] / kTileBlocks, b = place[row] / kTileBlocks;
      if (a != b) all[std::min(a, b)].push_back(std::max(a, b));
    }
  }
  for (std::vector<std::size_t>& rows : all) {
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    if (rows.empty()) continue;
    std::vector<std::size_t>& inherited = all[rows.front()];
    inherited.insert(inherited.end(), std::next(rows.begin()), rows.end());
  }
  return all;
}

}  // namespace

std::size_t factor_operations(const BlockPattern& pattern) {
  std::size_t operations = 0;
  for (const std::vector<std::size_t>& rows : tile_rows(pattern, places_of(sparse_order(pattern)))) {
    operations += (rows.size() + 1) * (rows.size() + 2) / 2;
  }
  return operations;
}

std::size_t dense_factor_operations(std::size_t blocks) {
  const std::size_t tiles = tiles_for(blocks);
  return tiles * (tiles + 1) * (tiles + 2) / 6;
}

double BlockMatrix::trace() const {
  double sum = 0;
  for (std::size_t column = 0; column < columns_.size(); ++column) {
    const auto diagonal = columns_[column].find(static_cast<std::uint32_t>(column));
    if (diagonal != columns_[column].end()) sum += diagonal->second.trace();
  }
  return sum;
}

BlockFactor::BlockFactor(const BlockMatrix& matrix, const CancelCheck& cancel_check)
    : panels_(tiles_for(matrix.blocks())) {
  const BlockPattern pattern = pattern_of(matrix);
  order_ = sparse_order(pattern);
  const std::vector<std::size_t> place = places_of(order_);
  std::vector<std::vector<std::size_t>> rows = tile_rows(pattern, place);
  for (std::size_t k = 0; k < panels_.size(); ++k) panels_[k].rows = std::move(rows[k]);
  fill(matrix, place);
  factorise(cancel_check);
}

Eigen::Index BlockFactor::first(std::size_t tile) const {
  return static_cast<Eigen::Index>(tile) * kTile;
}

Eigen::Index BlockFactor::size(std::size_t tile) const {
  return std::min(kTile, kBlock * static_cast<Eigen::Index>(order_.size()) - first(tile));
}

// Returns the row of a panel at which a tile begins.
Eigen::Index BlockFactor::row_in(std::size_t panel, std::size_t tile) const {
  if (tile == panel) return 0;
  const std::vector<std::size_t>& rows = panels_[panel].rows;
  return size(panel) + kTile * (std::lower_bound(rows.begin(), rows.end(), tile) - rows.begin());
}

void BlockFactor::fill(const BlockMatrix& matrix, const std::vector<std::size_t>& place) {
  for (std::size_t k = 0; k < panels_.size(); ++k) {
    Eigen::Index rows = size(k);
    for (const std::size_t tile : panels_[k].rows) rows += size(tile);
    panels_[k].tiles.setZero(rows, size(k));
  }
  for (std::size_t column = 0; column < matrix.blocks(); ++column) {
    for (const auto& [row, square] : matrix.column(column)) {
      const std::size_t low = std::max(place[row], place[column]), left = std::min(place[row], place[column]);
      const std::size_t panel = left / kTileBlocks;
      const auto in_tile = static_cast<Eigen::Index>(kBlock * (low % kTileBlocks));
      auto target = panels_[panel].tiles.block<kBlock, kBlock>(
          row_in(panel, low / kTileBlocks) + in_tile, static_cast<Eigen::Index>(kBlock * (left % kTileBlocks)));
      if (low == place[row]) {
        target = square;
      } else {
        target = square.transpose();
      }
    }
  }
}

// Subtracts a finished panel's part from another one.
void BlockFactor::update(std::size_t source, std::size_t target) {
  const Panel& from = panels_[source];
  Eigen::MatrixXd& to = panels_[target].tiles;
  const auto across = from.tiles.middleRows(row_in(source, target), size(target));
  const auto begin = std::lower_bound(from.rows.begin(), from.rows.end(), target);
  for (auto tile = begin; tile != from.rows.end(); ++tile) {
    to.middleRows(row_in(target, *tile), size(*tile)).noalias() -=
        from.tiles.middleRows(row_in(source, *tile), size(*tile)) * across.transpose();
  }
}

void BlockFactor::factorise(const CancelCheck& cancel_check) {
  for (std::size_t k = 0; k < panels_.size(); ++k) {
    check_cancelled(cancel_check);
    Panel& panel = panels_[k];
    Eigen::Ref<Eigen::MatrixXd> diagonal = panel.tiles.topRows(size(k));
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(diagonal);
    if (llt.info() != Eigen::Success || !diagonal.diagonal().allFinite()) {
      throw std::domain_error("normal equations: the matrix is not positive definite at the " + std::to_string(k + 1) +
                              "th of " + std::to_string(panels_.size()) + " tiles");
    }
    const std::vector<std::size_t>& rows = panel.rows;
    tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t i) {
      diagonal.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(
          panel.tiles.middleRows(row_in(k, rows[i]), size(rows[i])));
    });
    tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t i) {
      check_cancelled(cancel_check);
      update(k, rows[i]);
    });
    products_ += rows.size() * (rows.size() + 1) / 2;
  }
}

Eigen::MatrixXd BlockFactor::solve(const Eigen::MatrixXd& B, const CancelCheck& cancel_check) const {
  const auto unknowns = static_cast<Eigen::Index>(kBlock * order_.size());
  if (B.rows() != unknowns) {
    throw std::invalid_argument("normal equations: the right side has " + std::to_string(B.rows()) + " rows, must be " +
                                std::to_string(unknowns));
  }
  Eigen::MatrixXd X(B.rows(), B.cols());
  const auto row = [](std::size_t block) { return static_cast<Eigen::Index>(kBlock * block); };
  for (std::size_t i = 0; i < order_.size(); ++i) X.middleRows<kBlock>(row(i)) = B.middleRows<kBlock>(row(order_[i]));
  for (std::size_t k = 0; k < panels_.size(); ++k) {
    check_cancelled(cancel_check);
    const Panel& panel = panels_[k];
    auto own = X.middleRows(first(k), size(k));
    panel.tiles.topRows(size(k)).triangularView<Eigen::Lower>().solveInPlace(own);
    for (const std::size_t tile : panel.rows) {
      X.middleRows(first(tile), size(tile)).noalias() -= panel.tiles.middleRows(row_in(k, tile), size(tile)) * own;
    }
  }
  for (std::size_t k = panels_.size(); k-- > 0;) {
    check_cancelled(cancel_check);
    const Panel& panel = panels_[k];
    auto own = X.middleRows(first(k), size(k));
    for (const std::size_t tile : panel.rows) {
      own.noalias() -=
          panel.tiles.middleRows(row_in(k, tile), size(tile)).transpose() * X.middleRows(first(tile), size(tile));
    }
    panel.tiles.topRows(size(k)).triangularView<Eigen::Lower>().transpose().solveInPlace(own);
  }
  Eigen::MatrixXd result(B.rows(), B.cols());
  for (std::size_t i = 0; i < order_.size(); ++i) {
    result.middleRows<kBlock>(row(order_[i])) = X.middleRows<kBlock>(row(i));
  }
  return result;
}

}  // namespace lumatlas
