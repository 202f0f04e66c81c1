// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/budget/most_steps_within.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>

namespace lumatlas {
namespace {

TEST_CASE("as many steps are found as the bound allows, or as use up most of it, in few looks, whatever the law") {
  for (const std::size_t all : {1u, 2u, 3u, 10u, 43u, 180u, 1000u}) {
    for (const double power : {0.5, 1.0, 2.0, 6.0}) {
      for (const double largest : {0.0, 0.01, 0.05, 0.2, 1.0, 30.0}) {
        CAPTURE(all, power, largest);
        const auto loss_at = [&](std::size_t steps) {
          return largest * std::pow(static_cast<double>(steps) / static_cast<double>(all), power);
        };
        int looks = 0;
        const std::size_t found = most_steps_within(0.1, all, 1, [&](std::size_t steps) {
          CHECK(steps > 0);
          CHECK(steps < all);
          ++looks;
          return loss_at(steps);
        });
        CHECK(found < all);
        CHECK(loss_at(found) <= 0.1);
        const bool used_up = loss_at(found) >= 0.08;
        const bool next_is_too_far = found + 1 == all || loss_at(found + 1) > 0.1;
        CHECK((used_up || next_is_too_far));
        CHECK(looks <= 20);
      }
    }
  }
}

TEST_CASE("close enough saves looks, and a bound of nothing allows what loses nothing") {
  int looks = 0;
  const auto cliff = [&](std::size_t steps) {
    ++looks;
    return steps <= 700 ? -1.0 : 1.0;
  };
  CHECK(most_steps_within(0.1, 1000, 1, cliff) == 700);
  const int exact = looks;
  looks = 0;
  const std::size_t near = most_steps_within(0.1, 1000, 16, cliff);
  CHECK(near <= 700);
  CHECK(near > 700 - 16);
  CHECK(looks < exact);
  CHECK(most_steps_within(-0.2, 1000, 1, cliff) == 700);
  CHECK(most_steps_within(0, 1000, 1, [](std::size_t) { return 0.5; }) == 0);
  CHECK(most_steps_within(-2, 1000, 1, cliff) == 0);
}

}  // namespace
}  // namespace lumatlas
