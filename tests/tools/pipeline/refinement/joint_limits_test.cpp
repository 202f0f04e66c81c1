// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/refinement/joint_limits.h"

#include <catch2/catch.hpp>

namespace lumatlas {
namespace {

TEST_CASE("views that share points with too many others are told of, with what to do") {
  CHECK(too_large_together(2001) ==
        "2001 stored views share points with too many others to solve for all poses and lenses at once: each view is "
        "refined beside its neighbours instead, which leaves a drift that many views share; --max-views 400 keeps few "
        "enough");
}

}  // namespace
}  // namespace lumatlas
