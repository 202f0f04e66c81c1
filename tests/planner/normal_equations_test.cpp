// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/normal_equations.h"

#include <tbb/global_control.h>

#include <Eigen/Core>
#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <stdexcept>

namespace lumatlas {
namespace {

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return uniform(random); });
}

Eigen::MatrixXd positive_definite(Eigen::Index size) {
  const Eigen::MatrixXd half = random_matrix(size, size, 1);
  return half * half.transpose() + Eigen::MatrixXd::Identity(size, size);
}

// Overwrites what is not to be read.
Eigen::MatrixXd lower_of(Eigen::MatrixXd A) {
  A.triangularView<Eigen::StrictlyUpper>().setConstant(std::numeric_limits<double>::quiet_NaN());
  return A;
}

TEST_CASE("the solution solves, whether the size is one block, several, or part of one, and reads the lower triangle") {
  for (const Eigen::Index size : {1, 7, 95, 96, 97, 192, 300}) {
    CAPTURE(size);
    const Eigen::MatrixXd A = positive_definite(size);
    const Eigen::MatrixXd B = random_matrix(size, 3, 2);
    Eigen::MatrixXd lower = lower_of(A);
    const Eigen::MatrixXd X = solve_positive_definite(lower, B);
    CHECK((A * X - B).norm() < 1e-10 * A.norm());
  }
}

TEST_CASE("the solution has the same bits on one thread as on four") {
  const Eigen::MatrixXd A = positive_definite(500), B = random_matrix(500, 1, 3);
  const auto solved = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    Eigen::MatrixXd copy = A;
    return solve_positive_definite(copy, B);
  };
  CHECK(solved(1) == solved(4));
}

TEST_CASE("matrices that are not positive definite, not finite or of another size are refused") {
  const Eigen::MatrixXd B = random_matrix(200, 1, 4);
  Eigen::MatrixXd indefinite = positive_definite(200);
  indefinite(150, 150) = -1;
  CHECK_THROWS_AS(solve_positive_definite(indefinite, B), std::domain_error);
  for (const Eigen::Index at : {10, 150}) {
    Eigen::MatrixXd infinite = positive_definite(200);
    infinite(at, at) = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(solve_positive_definite(infinite, B), std::domain_error);
  }
  Eigen::MatrixXd small = positive_definite(100);
  CHECK_THROWS_AS(solve_positive_definite(small, B), std::invalid_argument);
  Eigen::MatrixXd oblong = random_matrix(200, 100, 5);
  CHECK_THROWS_AS(solve_positive_definite(oblong, B), std::invalid_argument);
}

TEST_CASE("a solution can be stopped at each block of columns") {
  struct Stop {};
  Eigen::MatrixXd A = positive_definite(300);
  int calls = 0;
  CHECK_THROWS_AS(solve_positive_definite(A, random_matrix(300, 1, 6),
                                          [&] {
                                            if (++calls == 3) throw Stop();
                                          }),
                  Stop);
}

}  // namespace
}  // namespace lumatlas
