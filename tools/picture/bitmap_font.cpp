// SPDX-License-Identifier: GPL-3.0-or-later
// OpenImageIO draws text only with a font file of the machine that it runs on. Legends must have the same size and
// bytes on every machine, so that pictures can be compared, and must not fail where no font is installed.
#include "tools/picture/bitmap_font.h"

#include <stb/stb_easy_font.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <string>
#include <vector>

namespace lumatlas {

namespace {

// A corner of a rectangle as stb_easy_font_print() writes it: four for each, the top left one first, the bottom right
// one third.
struct Corner {
  float x, y, z;  // dots, whole numbers
  unsigned char color[4];
};

constexpr std::size_t kMostRectangles = 24;  // per letter

bool continues_a_character(char byte) {
  return (static_cast<unsigned char>(byte) & 0xC0u) == 0x80u;
}

// Returns the text with one byte a letter, of those that the font has.
std::string drawable(std::string_view text) {
  std::string kept;
  std::copy_if(text.begin(), text.end(), std::back_inserter(kept), [](char c) { return !continues_a_character(c); });
  std::replace_if(
      kept.begin(), kept.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return kept;
}

void fill(Photograph& picture, std::int64_t left, std::int64_t top, std::int64_t right, std::int64_t bottom,
          const Rgb8& color) {
  right = std::min<std::int64_t>(right, picture.width);
  bottom = std::min<std::int64_t>(bottom, picture.height);
  for (std::int64_t y = std::max<std::int64_t>(top, 0); y < bottom; ++y) {
    for (std::int64_t x = std::max<std::int64_t>(left, 0); x < right; ++x) {
      std::copy(color.begin(), color.end(), picture.rgb.begin() + 3 * (y * picture.width + x));
    }
  }
}

}  // namespace

std::uint32_t text_width(std::string_view text, std::uint32_t scale) {
  return static_cast<std::uint32_t>(stb_easy_font_width(drawable(text).data())) * scale;
}

void draw_text(Photograph& picture, std::int64_t left, std::int64_t top, std::string_view text, std::uint32_t scale,
               const Rgb8& color) {
  std::string letters = drawable(text);
  std::vector<Corner> corners(4 * kMostRectangles * letters.size());
  const int rectangles = stb_easy_font_print(0, 0, letters.data(), nullptr, corners.data(),
                                             static_cast<int>(corners.size() * sizeof(Corner)));
  const auto pixels = [&](float dots) { return static_cast<std::int64_t>(dots) * scale; };
  for (std::size_t i = 0; i < static_cast<std::size_t>(rectangles); ++i) {
    const Corner &first = corners[4 * i], &last = corners[4 * i + 2];
    fill(picture, left + pixels(first.x), top + pixels(first.y), left + pixels(last.x), top + pixels(last.y), color);
  }
}

}  // namespace lumatlas
