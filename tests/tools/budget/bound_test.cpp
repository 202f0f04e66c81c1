// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/budget/bound.h"

#include <catch2/catch.hpp>
#include <limits>
#include <stdexcept>

namespace lumatlas {

TEST_CASE("a bound is on one thing, and on nothing until it is given") {
  CHECK(Bound().bytes() == 0);
  CHECK(Bound::of_array(7).array_bytes() == 7);
  CHECK(Bound::of_array(7).gpu_bytes() == 0);
  CHECK(Bound::of_gpu(7).gpu_bytes() == 7);
  CHECK(Bound::of_gpu(7).array_bytes() == 0);
  CHECK(Bound::of_gpu(7).bytes() == 7);
  CHECK(Bound::of_gpu(7).texel_loss_db() == 0);
  CHECK(Bound::of_loss(0.25, 0.5).bytes() == 0);
  CHECK(Bound::of_loss(0.25, 0.5).texel_loss_db() == 0.25);
  CHECK(Bound::of_loss(0.25, 0.5).face_loss_db() == 0.5);
}

TEST_CASE("a bound on the loss is finite and not negative") {
  CHECK_NOTHROW(check(Bound()));
  CHECK_NOTHROW(check(Bound::of_loss(0, 1)));
  CHECK_THROWS_AS(check(Bound::of_loss(-1, 0)), std::invalid_argument);
  CHECK_THROWS_AS(check(Bound::of_loss(0, std::numeric_limits<double>::infinity())), std::invalid_argument);
}

}  // namespace lumatlas
