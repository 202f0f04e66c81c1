// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/layout/filled_page.h"

#include <array>
#include <catch2/catch.hpp>

#include "atlas/images/srgb.h"

namespace lumatlas {
namespace {

std::array<int, 3> texel(const Photograph& page, std::size_t x, std::size_t y) {
  const std::uint8_t* rgb = &page.rgb[3 * (y * page.width + x)];
  return {rgb[0], rgb[1], rgb[2]};
}

glm::vec3 linear_of(int r, int g, int b) {
  const auto& linear = linear_from_srgb8();
  return {linear[static_cast<std::size_t>(r)], linear[static_cast<std::size_t>(g)],
          linear[static_cast<std::size_t>(b)]};
}

TEST_CASE("texels that were set stay, and the others take the colour of the nearest square that has one") {
  FilledPage page(8);
  page.set(0, 0, linear_of(10, 20, 30));
  page.set(1, 1, linear_of(30, 40, 50));
  page.set(7, 7, linear_of(200, 0, 100));
  const Photograph filled = page.finish();
  CHECK(filled.width == 8);
  CHECK(filled.rgb.size() == 3 * 64);
  CHECK(texel(filled, 0, 0) == std::array{10, 20, 30});
  CHECK(texel(filled, 1, 1) == std::array{30, 40, 50});
  CHECK(texel(filled, 0, 1) == std::array{20, 30, 40});
  CHECK(texel(filled, 3, 3) == std::array{20, 30, 40});
  CHECK(texel(filled, 6, 7) == std::array{200, 0, 100});
  CHECK(texel(filled, 4, 4) == std::array{200, 0, 100});
  CHECK(texel(filled, 7, 0) == std::array{110, 15, 70});  // the mean of both corners
}

TEST_CASE("one texel fills a page of any size, and none leaves it black") {
  for (const std::uint32_t side : {1u, 3u, 7u, 64u}) {
    CHECK(FilledPage(side).finish().rgb == std::vector<std::uint8_t>(3 * side * side, 0));
    FilledPage page(side);
    page.set(side / 2, side / 3, linear_of(90, 90, 90));
    CHECK(page.finish().rgb == std::vector<std::uint8_t>(3 * side * side, 90));
  }
}

}  // namespace
}  // namespace lumatlas
