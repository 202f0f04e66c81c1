// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/refinement/joint_limits.h"

#include <catch2/catch.hpp>

namespace lumatlas {
namespace {

TEST_CASE("views that share points with too many others for their lenses are told of, with what to do") {
  CHECK(too_large_for_lenses(2001) ==
        "2001 stored views share points with too many others to estimate their lenses, which stay as given; "
        "--max-views 800 keeps few enough");
}

}  // namespace
}  // namespace lumatlas
