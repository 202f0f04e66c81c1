// SPDX-License-Identifier: GPL-3.0-or-later
// Tests the predicted gain of surface that is added to a wall with a gap. The photographs' depth is known.
#include "tools/pipeline/surface/completion_gain.h"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/tools/pipeline/surface/gap_scenes.h"

namespace lumatlas {
namespace {

double largest_gain(const std::vector<SmallPhotograph>& photographs) {
  const std::optional<double> gain = largest_gain_db(photographs, *make_ray_visibility(wall_with_gap()), nullptr);
  REQUIRE(gain);
  return *gain;
}

TEST_CASE("a gap can cost much only where pictures are good beside it") {
  const double exact = largest_gain(wall_photographs());
  const double uneven = largest_gain(wall_photographs({.brighter = 0.5}));
  CHECK(exact > 3);
  CHECK(uneven > 0);
  CHECK(uneven < 0.25 * exact);
}

TEST_CASE("a gap costs nothing where its fill is right, nor where there is none") {
  CHECK(largest_gain(wall_photographs({.contrast = 0})) < 0.01);
  const std::unique_ptr<Visibility> whole = make_ray_visibility(wall_filled_at(kWall));
  CHECK(largest_gain_db(wall_photographs(), *whole, nullptr) == 0.0);
}

TEST_CASE("a gap that shows what is far lacks nothing") {
  Mesh behind;
  add_strip(-90, 90, 20, behind);
  const std::unique_ptr<Visibility> given = make_ray_visibility(wall_with_gap()), far = make_ray_visibility(behind);
  CHECK(largest_gain_db(wall_photographs(), *given, far.get()) == 0.0);
}

TEST_CASE("nothing is known of a gap that one photograph shows") {
  std::vector<SmallPhotograph> one = wall_photographs();
  one.resize(1);
  CHECK_FALSE(largest_gain_db(one, *make_ray_visibility(wall_with_gap()), nullptr));
}

TEST_CASE("the right surface in a gap brings nearly all that can be had, a wrong one makes pictures worse") {
  for (const double brighter : {0.0, 0.3}) {
    const std::vector<SmallPhotograph> photographs = wall_photographs({.brighter = brighter});
    const std::unique_ptr<Visibility> given = make_ray_visibility(wall_with_gap());
    const auto gain = [&](float depth) {
      return completion_gain_db(photographs, *given, nullptr, *make_ray_visibility(wall_filled_at(depth))).value();
    };
    CHECK(gain(kWall) > 0.8 * largest_gain(photographs));
    CHECK(gain(1.7F) < 0);
  }
}

}  // namespace
}  // namespace lumatlas
