// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/refinement/joint_limits.h"

#include <catch2/catch.hpp>

namespace lumatlas {
namespace {

TEST_CASE("too many lenses of too many views are told of, with what to do") {
  CHECK(too_many_lenses(2001) ==
        "2001 stored views share points with too many others to estimate more than 16 lenses: they stay as given; "
        "--max-views 400 keeps few enough, or give all photographs of a camera one lens");
}

}  // namespace
}  // namespace lumatlas
