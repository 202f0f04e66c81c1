// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/joint/block_matrix.h"

#include <tbb/global_control.h>

#include <Eigen/Core>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <stdexcept>
#include <utility>

#include "planner/refinement/joint/conjugate_gradients.h"
#include "planner/refinement/joint/joint_cost.h"

namespace lumatlas {
namespace {

// Which pairs of blocks have a square of the matrix that is not 0.
using Pairs = bool (*)(std::size_t row, std::size_t column);

bool every_pair(std::size_t, std::size_t) {
  return true;
}

// A lens, block 0, that all views share, and views along a walk that each share points with the eight before.
bool walk_with_a_lens(std::size_t row, std::size_t column) {
  return column == 0 || row - column <= 8;
}

// Each view has points in common with few others, which may be anywhere.
bool scattered_pairs(std::size_t row, std::size_t column) {
  return row == column || (row * 7 + column * 13) % 29 == 0;
}

BlockMatrix positive_definite(std::size_t blocks, Pairs has_square) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  BlockMatrix matrix(blocks);
  for (std::size_t row = 0; row < blocks; ++row) {
    for (std::size_t column = 0; column < row; ++column) {
      if (!has_square(row, column)) continue;
      matrix.at(row, column) = BlockSquare::NullaryExpr([&] { return uniform(random); });
    }
    matrix.at(row, row).diagonal().setConstant(static_cast<double>(kBlock * blocks));  // more than its row's sum
  }
  return matrix;
}

Eigen::MatrixXd dense(const BlockMatrix& matrix) {
  const auto at = [](std::size_t block) { return static_cast<Eigen::Index>(kBlock * block); };
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(at(matrix.blocks()), at(matrix.blocks()));
  for (std::size_t column = 0; column < matrix.blocks(); ++column) {
    for (const auto& [row, square] : matrix.column(column)) {
      result.block<kBlock, kBlock>(at(row), at(column)) = square;
      result.block<kBlock, kBlock>(at(column), at(row)) = square.transpose();
    }
  }
  return result;
}

Eigen::MatrixXd right_sides(std::size_t blocks, Eigen::Index columns) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  return Eigen::MatrixXd::NullaryExpr(static_cast<Eigen::Index>(kBlock * blocks), columns,
                                      [&] { return uniform(random); });
}

TEST_CASE("the solution solves, whichever pairs of blocks have a square, and whether tiles are full or not") {
  const Pairs has_square = GENERATE(every_pair, walk_with_a_lens, scattered_pairs);
  for (const std::size_t blocks : {1, 2, 13, 14, 15, 28, 43, 100}) {
    CAPTURE(blocks);
    const BlockMatrix matrix = positive_definite(blocks, has_square);
    const Eigen::MatrixXd A = dense(matrix), B = right_sides(blocks, 3);
    CHECK((A * BlockFactor(matrix).solve(B) - B).norm() < 1e-12 * B.norm());
    CHECK(matrix.trace() == Approx(A.trace()));
  }
}

TEST_CASE("of a square on the diagonal only the lower triangle is read") {
  BlockMatrix matrix = positive_definite(20, every_pair);
  const Eigen::MatrixXd B = right_sides(20, 1), X = BlockFactor(matrix).solve(B);
  for (std::size_t block = 0; block < 20; ++block) {
    matrix.at(block, block)
        .triangularView<Eigen::StrictlyUpper>()
        .setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  CHECK(BlockFactor(matrix).solve(B) == X);
}

TEST_CASE("along a walk the cost of a solution grows with the number of views, where all share points with its cube") {
  const auto products = [](std::size_t blocks, Pairs has_square) {
    return static_cast<double>(BlockFactor(positive_definite(blocks, has_square)).products());
  };
  const double few = products(400, walk_with_a_lens), many = products(800, walk_with_a_lens);
  CAPTURE(few, many);
  CHECK(many < 2.2 * few);
  CHECK(many < 0.02 * products(800, every_pair));
  CHECK(products(14 * 8, every_pair) == 7.0 * 8 * 9 / 6);
}

TEST_CASE("what a factor takes is known before it is made, from the pattern of the matrix") {
  const auto pattern_of_pairs = [](std::size_t blocks, Pairs has_square) {
    BlockPattern pattern(blocks);
    for (std::size_t column = 0; column < blocks; ++column) {
      for (std::size_t row = column; row < blocks; ++row) {
        if (row == column || has_square(row, column)) pattern[column].push_back(static_cast<std::uint32_t>(row));
      }
    }
    return pattern;
  };
  for (const std::size_t blocks : {1, 14, 15, 100, 300}) {
    CAPTURE(blocks);
    const std::size_t tiles = (blocks + 13) / 14;
    for (const Pairs has_square : {every_pair, walk_with_a_lens, scattered_pairs}) {
      const BlockFactor factor(positive_definite(blocks, has_square));
      // Each tile of the factor is also made once.
      CHECK(factor_operations(pattern_of_pairs(blocks, has_square)) >= factor.products() + tiles);
      CHECK(factor_operations(pattern_of_pairs(blocks, has_square)) <= dense_factor_operations(blocks));
    }
    CHECK(factor_operations(pattern_of_pairs(blocks, every_pair)) == dense_factor_operations(blocks));
  }
  CHECK(factor_operations({}) == 0);
  const std::size_t few = factor_operations(pattern_of_pairs(1000, walk_with_a_lens));
  CHECK(factor_operations(pattern_of_pairs(4000, walk_with_a_lens)) < 5 * few);
  CHECK(20 * few < dense_factor_operations(1000));
}

TEST_CASE("490 views and lenses are factored, also where all are in sight of all") {
  CHECK(dense_factor_operations(490) <= kMostStepOperations);
  CHECK(dense_factor_operations(491) > kMostStepOperations);
}

TEST_CASE("conjugate gradients solve what a factor solves") {
  const Pairs has_square = GENERATE(every_pair, walk_with_a_lens, scattered_pairs);
  const std::size_t blocks = GENERATE(1, 3, 90);
  CAPTURE(blocks);
  const BlockMatrix matrix = positive_definite(blocks, has_square);
  const Eigen::VectorXd b = right_sides(blocks, 1), exact = BlockFactor(matrix).solve(b);
  const GradientSolution found = solve_by_gradients(matrix, b, {.least_residual = 1e-12});
  CHECK(found.residual <= 1e-12);
  CHECK((found.x - exact).norm() < 1e-9 * exact.norm());
  CHECK(found.steps <= 7 * blocks);
  const GradientSolution rough = solve_by_gradients(matrix, b, {.least_residual = 1e-2});
  CHECK(rough.residual <= 1e-2);
  CHECK(rough.steps <= found.steps);
  CHECK(solve_by_gradients(matrix, b, {.most_steps = 0}).x == Eigen::VectorXd::Zero(b.size()));
  CHECK(solve_by_gradients(matrix, Eigen::VectorXd::Zero(b.size())).x == Eigen::VectorXd::Zero(b.size()));
}

TEST_CASE("conjugate gradients read the lower triangle of a diagonal square alone, and refuse what has no solution") {
  BlockMatrix matrix = positive_definite(5, every_pair);
  const Eigen::VectorXd b = right_sides(5, 1), x = solve_by_gradients(matrix, b).x;
  matrix.at(2, 2)(0, 6) = std::numeric_limits<double>::quiet_NaN();
  CHECK(solve_by_gradients(matrix, b).x == x);
  CHECK_THROWS_AS(solve_by_gradients(matrix, b.head(34)), std::invalid_argument);
  matrix.at(3, 3).setZero();
  CHECK_THROWS_WITH(solve_by_gradients(matrix, b), Catch::Contains("block 3 is not positive definite"));
  matrix.at(3, 3).diagonal().setConstant(std::numeric_limits<double>::quiet_NaN());
  CHECK_THROWS_AS(solve_by_gradients(matrix, b), std::domain_error);
  const auto stop = [] { throw std::runtime_error("cancelled"); };
  CHECK_THROWS_WITH(solve_by_gradients(positive_definite(5, every_pair), b, {}, stop), "cancelled");
}

TEST_CASE("the solution has the same bits on one thread as on four") {
  const BlockMatrix matrix = positive_definite(70, scattered_pairs);
  const Eigen::MatrixXd B = right_sides(70, 1);
  const auto solved = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return std::pair(BlockFactor(matrix).solve(B), solve_by_gradients(matrix, B.col(0)).x);
  };
  CHECK(solved(1) == solved(4));
}

TEST_CASE("matrices that are not positive definite or not finite, and right sides of another size, are refused") {
  BlockMatrix indefinite = positive_definite(40, every_pair);
  indefinite.at(30, 30)(2, 2) = -1;
  CHECK_THROWS_AS(BlockFactor(indefinite), std::domain_error);
  for (const std::size_t at : {1, 30}) {
    BlockMatrix infinite = positive_definite(40, every_pair);
    infinite.at(at, at)(3, 3) = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(BlockFactor(infinite), std::domain_error);
  }
  CHECK_THROWS_AS(BlockFactor(BlockMatrix(3)), std::domain_error);
  CHECK_THROWS_AS(BlockFactor(positive_definite(3, every_pair)).solve(right_sides(2, 1)), std::invalid_argument);
}

TEST_CASE("a solution can be stopped at each column of tiles") {
  struct Stop {};
  const BlockMatrix matrix = positive_definite(60, every_pair);
  int calls = 0;
  const auto stop_at_third = [&] {
    if (++calls == 3) throw Stop();
  };
  CHECK_THROWS_AS(BlockFactor(matrix, stop_at_third), Stop);
  const BlockFactor factor(matrix);
  calls = 0;
  CHECK_THROWS_AS(factor.solve(right_sides(60, 1), stop_at_third), Stop);
}

}  // namespace
}  // namespace lumatlas
