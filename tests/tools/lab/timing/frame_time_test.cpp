// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/timing/frame_time.h"

#include <catch2/catch.hpp>

namespace lumatlas {
namespace {

TEST_CASE("a picture that is timed has pixels") {
  CHECK_THROWS_WITH(cameras_between_views(Snapshot(), 3, {0, 1080}), Catch::Contains("it is 0x1080 pixels"));
  CHECK_THROWS_WITH(cameras_between_views(Snapshot(), 3, {1920, 0}), Catch::Contains("it is 1920x0 pixels"));
  CHECK(cameras_between_views(Snapshot(), 3, {1920, 1080}).empty());
}

}  // namespace
}  // namespace lumatlas
