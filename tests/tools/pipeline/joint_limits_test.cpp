// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/refinement/joint_limits.h"

#include <catch2/catch.hpp>

namespace lumatlas {
namespace {

TEST_CASE("more views than are solved for together are told of, with what to do") {
  CHECK_FALSE(too_many_together(kMostJointViews));
  CHECK(can_be_solved_for_together(kMostJointViews));
  const auto sentence = too_many_together(kMostJointViews + 1);
  REQUIRE(sentence);
  CHECK(*sentence ==
        "401 stored views are too many to solve for all poses and lenses at once (at most 400): each view is refined "
        "beside its neighbours instead, which leaves a drift that many views share; --max-views 400 keeps few enough");
  CHECK_FALSE(can_be_solved_for_together(kMostJointViews + 1));
}

}  // namespace
}  // namespace lumatlas
