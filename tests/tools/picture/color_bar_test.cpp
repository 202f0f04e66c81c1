// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/color_bar.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "tools/picture/bitmap_font.h"

namespace lumatlas {
namespace {

Photograph blank(std::uint32_t width, std::uint32_t height, std::uint8_t level) {
  Photograph picture;
  picture.width = width;
  picture.height = height;
  picture.rgb.assign(std::size_t{3} * width * height, level);
  return picture;
}

Rgb8 color_at(const Photograph& picture, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t* rgb = &picture.rgb[3 * (std::size_t{y} * picture.width + x)];
  return {rgb[0], rgb[1], rgb[2]};
}

// Returns the pixels that a text colours in a picture of its size, with a margin around it, as '#' and '.'.
std::string drawn(std::string_view text, std::uint32_t scale = 1, std::uint32_t margin = 0) {
  Photograph picture = blank(text_width(text, scale) + 2 * margin, kGlyphHeight * scale + 2 * margin, 0);
  draw_text(picture, margin, margin, text, scale, {255, 255, 255});
  std::string dots;
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3) dots += picture.rgb[i] != 0 ? '#' : '.';
  return dots;
}

TEST_CASE("every letter that a legend may need looks like no other, and none is larger than its size says") {
  const std::string letters = "0123456789.,:-+=ABCDEFGHIJKLMNOPQRSTUVWXYZ_/()%?abcdefghijklmnopqrstuvwxyz<>";
  std::set<std::string> shapes;
  for (const char letter : letters) {
    const std::string text(1, letter), shape = drawn(text), amid_space = drawn(text, 1, 9);
    CAPTURE(letter);
    const auto count = std::count(shape.begin(), shape.end(), '#');
    CHECK(count >= 1);
    CHECK(std::count(amid_space.begin(), amid_space.end(), '#') == count);
    shapes.insert(shape);
  }
  CHECK(shapes.size() == letters.size());
  CHECK(drawn(" ").find('#') == std::string::npos);
}

TEST_CASE("what the font lacks is drawn as question marks, one for each character") {
  for (const std::string missing : {"\t", "\n", "\x7f", "\xc3\xa4", "\xe2\x82\xac"}) {
    CAPTURE(missing);
    CHECK(drawn(missing) == drawn("?"));
    CHECK(drawn("a" + missing + "b") == drawn("a?b"));
  }
}

TEST_CASE("text takes as many dots as its letters, at every scale, and is cut off at the picture's edge") {
  CHECK(text_width("", 3) == 0);
  CHECK(drawn("").empty());
  CHECK(text_width("ab", 1) == text_width("a", 1) + text_width("b", 1));
  CHECK(text_width("ab", 3) == 3 * text_width("ab", 1));
  const std::string small = drawn("H1");
  const std::string large = drawn("H1", 2);
  CHECK(std::count(large.begin(), large.end(), '#') == 4 * std::count(small.begin(), small.end(), '#'));
  Photograph picture = blank(8, 4, 0);
  for (const std::int64_t at : {-1000, -7, 3, 7, 8, 1000}) {
    CHECK_NOTHROW(draw_text(picture, at, at, "0.5", 2, {255, 255, 255}));
  }
}

TEST_CASE("the numbers of a bar are round, within its range, and no more than fit") {
  using Numbers = std::vector<double>;
  CHECK(round_numbers(0, 1, 6, false) == Numbers{0, 0.2, 0.4, 0.6000000000000001, 0.8, 1});
  CHECK(round_numbers(0, 16, 6, true) == Numbers{0, 5, 10, 15});
  CHECK(round_numbers(0, 3, 8, true) == Numbers{0, 1, 2, 3});
  CHECK(round_numbers(0, 1, 8, true) == Numbers{0, 1});
  CHECK(round_numbers(-3, 41, 5, false) == Numbers{0, 10, 20, 30, 40});
  for (const double most : {1e-7, 0.013, 0.3, 0.99, 7.0, 64.0, 1234.5, 8e12}) {
    for (const double least : {0.0, most / 3, -most}) {
      for (std::size_t count = 2; count < 15; ++count) {
        CAPTURE(least, most, count);
        const Numbers numbers = round_numbers(least, most, count, false);
        CHECK(numbers.size() <= count);
        CHECK(!numbers.empty());
        CHECK(std::is_sorted(numbers.begin(), numbers.end()));
        CHECK(numbers.front() >= least - 1e-9 * most);
        CHECK(numbers.back() <= most * (1 + 1e-9));
      }
    }
  }
}

ColorBar quantity_bar() {
  return {"coverage (1 is the best)", ColorScale{0, 1, quantity_ramp, false, true}, {{{9, 200, 9}, "green things"}}};
}

TEST_CASE("a picture with a colour bar keeps its pixels, and has the whole ramp and the named colours below them") {
  for (const auto& [width, height] : {std::pair{640u, 480u}, {48u, 36u}, {1u, 1u}, {300u, 1900u}}) {
    CAPTURE(width, height);
    const Photograph picture = blank(width, height, 77);
    const Photograph canvas = with_color_bar(picture, quantity_bar());
    REQUIRE(canvas.rgb.size() == std::size_t{3} * canvas.width * canvas.height);
    CHECK(canvas.height > height);
    CHECK(canvas.width >= width);
    std::set<Rgb8> below;
    for (std::uint32_t y = 0; y < canvas.height; ++y) {
      for (std::uint32_t x = 0; x < canvas.width; ++x) {
        if (y >= height) below.insert(color_at(canvas, x, y));
        if (y < height && x < width) REQUIRE(color_at(canvas, x, y) == Rgb8{77, 77, 77});
      }
    }
    CHECK(below.contains({9, 200, 9}));
    CHECK(below.size() > 100);  // of the ramp, letters and background
  }
  CHECK(with_color_bar(blank(800, 600, 0), quantity_bar()).width == 800);
}

TEST_CASE("colours on a bar lie where its numbers say") {
  const Photograph canvas = with_color_bar(blank(540, 540, 0), quantity_bar());
  const std::uint32_t dot = 2;
  const std::uint32_t left = 5 * dot;
  const std::uint32_t width = 540 - 2 * left;
  const std::uint32_t row = 540 + (5 + 9 + 3 + 4) * dot;
  for (const double part : {0.0, 0.25, 0.5, 0.75, 0.999}) {
    const Rgb8 shown = color_at(canvas, left + static_cast<std::uint32_t>(part * width), row);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      CHECK(std::abs(shown[channel] - quantity_ramp(part)[channel]) <= 2);
    }
  }
}

TEST_CASE("many names take several lines, and a bar may have names alone") {
  ColorBar bar{"winning view", std::nullopt, {}};
  const Photograph none = with_color_bar(blank(320, 240, 0), bar);
  for (std::uint32_t i = 0; i < 9; ++i) bar.names.push_back({distinct_color(i), "frame-00000" + std::to_string(i)});
  const Photograph nine = with_color_bar(blank(320, 240, 0), bar);
  CHECK(none.width == nine.width);
  CHECK(nine.height > none.height + 3 * 12 * 2);
  for (std::uint32_t i = 0; i < 9; ++i) {
    std::size_t found = 0;
    for (std::uint32_t y = 240; y < nine.height; ++y) {
      for (std::uint32_t x = 0; x < nine.width; ++x) found += color_at(nine, x, y) == distinct_color(i);
    }
    CHECK(found == 12 * 12);  // within the rim
  }
}

TEST_CASE("a scale without extent is refused") {
  ColorBar bar = quantity_bar();
  bar.scale->least = 1;
  CHECK_THROWS_WITH(with_color_bar(blank(9, 9, 0), bar), Catch::Contains("from 1 to 1, must be finite and ascending"));
  bar.scale->most = std::numeric_limits<double>::infinity();
  CHECK_THROWS_WITH(with_color_bar(blank(9, 9, 0), bar), Catch::Contains("from 1 to inf"));
}

}  // namespace
}  // namespace lumatlas
