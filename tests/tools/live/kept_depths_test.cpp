// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/kept_depths.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <limits>

#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

// A slope with steps up and down, and pixels that were not measured.
RoundedDepth sloped(std::uint16_t from) {
  RoundedDepth image{0.001, {}};
  for (std::uint32_t pixel = 0; pixel < 3000; ++pixel) {
    const std::uint32_t value = from + pixel + 30000 * (pixel / 7 % 2);
    image.steps.push_back(static_cast<std::uint16_t>(pixel % 11 == 0 ? 0 : value));
  }
  return image;
}

TEST_CASE("depths are rounded to steps, and packed without loss") {
  const float nothing = std::numeric_limits<float>::quiet_NaN(), endless = std::numeric_limits<float>::infinity();
  const std::vector<float> depth{0, 1, 2.0004F, nothing, endless, -1, 1e-9F, 65.535F};
  const RoundedDepth rounded = rounded_depth(depth, 0.001);
  CHECK((rounded.steps == std::vector<std::uint16_t>{0, 1000, 2000, 0, 0, 0, 1, 65535}));
  const RoundedDepth far = rounded_depth(std::vector<float>{1, 1000}, 0.001);  // steps become larger
  CHECK(far.steps.back() == 65535);
  CHECK(std::abs(depths_of(far).front() - 1) < 0.01F);
  for (const RoundedDepth& image : {rounded, far, sloped(5), RoundedDepth{1, {}}}) {
    const RoundedDepth read = unpacked(packed(image));
    CHECK(read.unit == image.unit);
    CHECK(read.steps == image.steps);
  }
}

TEST_CASE("depth images are kept in memory, then in a file that goes, and then no more") {
  const TemporaryFolder folder;
  const std::size_t size = packed(sloped(0)).size();
  {
    KeptDepths kept(folder.path(), 2 * size + size / 2, 5 * size + size / 2);
    for (std::uint16_t number = 0; number < 5; ++number) {
      CHECK(std::filesystem::is_empty(folder.path()) == (number <= 2));
      REQUIRE(kept.keep(sloped(number)) == number);
    }
    CHECK_FALSE(kept.keep(sloped(5)));
    CHECK(kept.bytes() <= 5 * size + size / 2);
    for (const std::size_t number : {4U, 0U, 3U, 2U, 1U}) {
      CHECK(kept.image(number).steps == sloped(static_cast<std::uint16_t>(number)).steps);
    }
  }
  CHECK(std::filesystem::is_empty(folder.path()));
  KeptDepths homeless(folder.path() / "none", 0, 100 * size);
  CHECK_FALSE(homeless.keep(sloped(0)));
}

}  // namespace
}  // namespace lumatlas
