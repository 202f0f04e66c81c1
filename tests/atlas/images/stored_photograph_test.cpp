// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/images/stored_photograph.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>
#include <random>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "atlas/images/pixel_list.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

using Numbers = PixelList<std::uint16_t>;

// Returns different values for the pixels of a rectangle.
std::vector<std::uint16_t> values_in(const PixelRect& rect) {
  std::vector<std::uint16_t> values;
  for (std::uint32_t y = rect.y; y < rect.bottom(); ++y) {
    for (std::uint32_t x = rect.x; x < rect.right(); ++x) values.push_back(static_cast<std::uint16_t>(1 + 300 * y + x));
  }
  return values;
}

TEST_CASE("a list of parts reads like the list of all of its pixels") {
  constexpr std::uint32_t kColumns = 147, kRows = 201;  // neither whole blocks nor whole pages
  constexpr std::uint16_t kElsewhere = 65535;
  Numbers parts(kColumns, kRows, kElsewhere);
  std::vector<std::uint16_t> all(std::size_t{kColumns} * kRows, kElsewhere);
  CHECK(parts == Numbers(all));
  std::mt19937 random(3);
  for (int i = 0; i < 12; ++i) {
    const auto below = [&](std::uint32_t end) { return static_cast<std::uint32_t>(random() % end); };
    const std::uint32_t x = below(kColumns), y = below(kRows);
    const PixelRect part{x, y, below(std::min(30u, kColumns - x + 1)), below(std::min(30u, kRows - y + 1))};
    const std::vector<std::uint16_t> values = values_in(part);
    parts.set_part(part, values);
    for (std::size_t number = 0; number < values.size(); ++number) {
      all[(part.y + number / part.width) * kColumns + part.x + number % part.width] = values[number];
    }
  }
  REQUIRE(parts.size() == all.size());
  CHECK_FALSE(parts.has_all());
  for (std::size_t pixel = 0; pixel < all.size(); ++pixel) {
    if (parts[pixel] != all[pixel]) FAIL_CHECK("pixel " << pixel);
  }
  CHECK(parts.all() == all);
  for (const Numbers& list : {parts, Numbers(all)}) {
    std::vector<std::uint16_t> run(1000);
    list.copy(777, run);
    CHECK(std::equal(run.begin(), run.end(), all.begin() + 777));
  }
  CHECK(parts == Numbers(all));
  CHECK(Numbers(all) == parts);
  std::size_t last = 0, counted = 0, own = 0;
  parts.for_each([&](std::size_t pixel, std::uint16_t value) {
    CHECK((counted == 0 || pixel > last));
    last = pixel;
    ++counted;
    own += value != kElsewhere ? 1 : 0;
    if (value != all[pixel]) FAIL_CHECK("pixel " << pixel);
  });
  CHECK(own == all.size() - static_cast<std::size_t>(std::count(all.begin(), all.end(), kElsewhere)));
  CHECK(counted < all.size() / 2);

  const Numbers before = parts;
  parts.settle();
  CHECK(parts == before);
  CHECK(parts.bytes() <= before.bytes());
  Numbers copy = parts;
  CHECK(copy == before);
  copy.set_part({3, 4, 2, 1}, std::vector<std::uint16_t>{8, 9});  // a list that is settled takes more parts
  CHECK(copy[4 * kColumns + 4] == 9);
  CHECK(parts[4 * kColumns + 4] == all[4 * kColumns + 4]);
  copy.settle();
  all[4 * kColumns + 3] = 8;
  all[4 * kColumns + 4] = 9;
  CHECK(copy.all() == all);
  parts = copy;

  parts.values()[5] = 7;  // every pixel has a value of its own from here on
  CHECK(parts.has_all());
  all[5] = 7;
  CHECK(parts.all() == all);
}

TEST_CASE("a list of parts takes the memory of its parts, not of the image") {
  Numbers parts(4000, 3000, 0);
  const std::size_t empty = parts.bytes();
  CHECK(empty <= 4000 * 3000 / 500);
  const PixelRect part{1000, 1000, 64, 64};
  parts.set_part(part, values_in(part));
  CHECK(parts.bytes() - empty <= 2 * sizeof(std::uint16_t) * (64 + 8) * (64 + 8));
}

TEST_CASE("a part that is none of the image, or has other values than pixels, is refused") {
  Numbers parts(20, 10, 0);
  CHECK_THROWS_AS(parts.set_part({18, 0, 3, 1}, std::vector<std::uint16_t>(3)), std::invalid_argument);
  CHECK_THROWS_AS(parts.set_part({0, 9, 1, 2}, std::vector<std::uint16_t>(2)), std::invalid_argument);
  CHECK_THROWS_AS(parts.set_part({~0u, 0, 2, 1}, std::vector<std::uint16_t>(2)), std::invalid_argument);
  CHECK_THROWS_AS(parts.set_part({0, 0, 2, 2}, std::vector<std::uint16_t>(3)), std::invalid_argument);
  Numbers whole(std::vector<std::uint16_t>(200));
  CHECK_THROWS_AS(whole.set_part({0, 0, 1, 1}, std::vector<std::uint16_t>(1)), std::invalid_argument);
  CHECK_THROWS_AS(Numbers(0, 10, 0), std::invalid_argument);
}

// Keeps parts of a photograph that is read in bands of `rows` rows.
StoredPhotograph in_parts(const Photograph& whole, const std::vector<PixelRect>& parts, std::uint32_t rows = 7) {
  return {{whole.width, whole.height}, whole.valid, parts, [&](const PixelRows& use) {
            const std::size_t row_bytes = std::size_t{3} * whole.width;
            for (std::uint32_t row = 0; row < whole.height; row += rows) {
              use(row, std::span(whole.rgb).subspan(row * row_bytes, std::min(rows, whole.height - row) * row_bytes));
            }
          }};
}

TEST_CASE("a photograph in parts has their pixels, and the lens shows nothing elsewhere") {
  const Photograph whole = position_photograph(100, 80);
  const std::vector<PixelRect> rects{{10, 20, 30, 8}, {90, 0, 10, 80}};
  const StoredPhotograph parts = in_parts(whole, rects), all{Photograph(whole)};
  CHECK(parts.width() == 100);
  CHECK(parts.height() == 80);
  CHECK_FALSE(parts.has_lens_mask());
  const Photograph black_elsewhere = parts.whole();
  std::size_t inside = 0;
  for (std::uint32_t y = 0; y < 80; ++y) {
    for (std::uint32_t x = 0; x < 100; ++x) {
      const std::size_t pixel = std::size_t{y} * 100 + x;
      const bool there = (x >= 10 && x < 40 && y >= 20 && y < 28) || x >= 90;
      const StoredPhotograph::Color expected = there ? all.color(pixel) : StoredPhotograph::Color{};
      const bool same = parts.color(pixel) == expected && parts.is_inside_lens(pixel) == there &&
                        black_elsewhere.rgb[3 * pixel + 1] == expected[1] &&
                        (black_elsewhere.valid[pixel] != 0) == there;
      if (!same) FAIL_CHECK("pixel " << x << ", " << y);
      inside += there ? 1 : 0;
    }
  }
  CHECK(inside == 30 * 8 + 10 * 80);
  CHECK(parts.bytes() < all.bytes());
  CHECK(all.is_inside_lens(0));
  CHECK(all.valid().empty());
  CHECK(all.span().rgb.data() == all.span().rgb.data());  // not copied
  CHECK(std::ranges::equal(all.span().rgb, whole.rgb));
  CHECK(all.span().valid.empty());
  CHECK_THROWS_AS(parts.span(), std::logic_error);
  CHECK_FALSE(parts == all);
  CHECK(in_parts(whole, {{0, 0, 100, 80}}, 80).color(4321) == all.color(4321));
}

TEST_CASE("a photograph in parts keeps the mask of its lens") {
  Photograph whole = position_photograph(20, 10);
  whole.valid.assign(200, 255);
  whole.valid[25] = 0;
  const StoredPhotograph parts = in_parts(whole, {{0, 0, 10, 10}});
  CHECK(parts.has_lens_mask());
  CHECK_FALSE(parts.is_inside_lens(25));
  CHECK(parts.is_inside_lens(24));
  CHECK_FALSE(parts.is_inside_lens(15));
}

TEST_CASE("a photograph whose lists do not fit its size cannot be stored") {
  Photograph cut = position_photograph(4, 4);
  cut.rgb.pop_back();
  CHECK_THROWS_WITH(StoredPhotograph(cut), "photograph: rgb has 47 values, must have 48 for its 4x4 pixels");
  Photograph masked = position_photograph(4, 4);
  masked.valid = {255};
  CHECK_THROWS_WITH(StoredPhotograph(masked), "photograph: valid has 1 values, must have 16 for its 4x4 pixels");
  CHECK_THROWS_AS(in_parts(position_photograph(4, 4), {{2, 0, 3, 1}}), std::invalid_argument);
  CHECK_THROWS_WITH(in_parts(masked, {}), "photograph: valid has 1 values, must have 16 for its 4x4 pixels");
}

}  // namespace
}  // namespace lumatlas
