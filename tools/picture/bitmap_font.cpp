// SPDX-License-Identifier: GPL-3.0-or-later
// OpenImageIO draws text only with a font file of the machine that it runs on. Legends must have the same size and
// bytes on every machine, so that pictures can be compared, and must not fail where no font is installed.
#include "tools/picture/bitmap_font.h"

#include <algorithm>
#include <array>
#include <string>

namespace lumatlas {

namespace {

constexpr std::size_t kGlyphWidth = kGlyphAdvance - 1;

// Glyphs side by side, a column of dots between them.
struct GlyphRow {
  std::string_view characters;
  std::array<std::string_view, kGlyphHeight> dots;
};

// clang-format off
constexpr std::array<GlyphRow, 5> kGlyphs{{
    {"0123456789.,:-+=",
     {{
         ".###. ..#.. .###. .###. ...#. ##### ..##. ##### .###. .###. ..... ..... ..... ..... ..... .....",
         "#...# .##.. #...# #...# ..##. #.... .#... ....# #...# #...# ..... ..... ..... ..... ..#.. .....",
         "#..## ..#.. ....# ....# .#.#. ####. #.... ...#. #...# #...# ..... ..... ..#.. ..... ..#.. #####",
         "#.#.# ..#.. ..##. ..##. #..#. ....# ####. ...#. .###. .#### ..... ..... ..#.. ##### ##### .....",
         "##..# ..#.. .#... ....# ##### ....# #...# ..#.. #...# ....# ..... ..... ..... ..... ..#.. #####",
         "#...# ..#.. #.... #...# ...#. #...# #...# ..#.. #...# ...#. ..#.. ..#.. ..#.. ..... ..#.. .....",
         ".###. .###. ##### .###. ...#. .###. .###. ..#.. .###. .##.. ..#.. ..#.. ..#.. ..... ..... .....",
         "..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... .#... ..... ..... ..... .....",
         "..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ....."}}},
    {"ABCDEFGHIJKLMNOP",
     {{
         "..#.. ####. .###. ###.. ##### ##### .###. #...# .###. ..### #...# #.... #...# #...# .###. ####.",
         ".#.#. #...# #...# #..#. #.... #.... #...# #...# ..#.. ...#. #..#. #.... ##.## ##..# #...# #...#",
         "#...# #...# #.... #...# #.... #.... #.... #...# ..#.. ...#. #.#.. #.... #.#.# ##..# #...# #...#",
         "#...# ####. #.... #...# ####. ####. #.### ##### ..#.. ...#. ##... #.... #.#.# #.#.# #...# ####.",
         "##### #...# #.... #...# #.... #.... #...# #...# ..#.. ...#. #.#.. #.... #...# #..## #...# #....",
         "#...# #...# #...# #..#. #.... #.... #...# #...# ..#.. #..#. #..#. #.... #...# #..## #...# #....",
         "#...# ####. .###. ###.. ##### #.... .#### #...# .###. .##.. #...# ##### #...# #...# .###. #....",
         "..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... .....",
         "..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ....."}}},
    {"QRSTUVWXYZ_/()%?",
     {{
         ".###. ####. .#### ##### #...# #...# #...# #...# #...# ##### ..... ....# ...#. .#... ##..# .###.",
         "#...# #...# #.... ..#.. #...# #...# #...# #...# #...# ....# ..... ....# ..#.. ..#.. ##..# #...#",
         "#...# #...# #.... ..#.. #...# #...# #...# .#.#. .#.#. ...#. ..... ...#. .#... ...#. ...#. ....#",
         "#...# ####. .###. ..#.. #...# #...# #.#.# ..#.. ..#.. ..#.. ..... ..#.. .#... ...#. ..#.. ...#.",
         "#.#.# #.#.. ....# ..#.. #...# .#.#. #.#.# .#.#. ..#.. .#... ..... .#... .#... ...#. .#... ..#..",
         "#..#. #..#. ....# ..#.. #...# .#.#. ##.## #...# ..#.. #.... ..... #.... ..#.. ..#.. #..## .....",
         ".##.# #...# ####. ..#.. .###. ..#.. #...# #...# ..#.. ##### ..... #.... ...#. .#... #..## ..#..",
         "..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ##### ..... ..... ..... ..... .....",
         "..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ....."}}},
    {"abcdefghijklmnop",
     {{
         "..... #.... ..... ....# ..... ..##. ..... #.... ..#.. ...#. #.... .##.. ..... ..... ..... .....",
         "..... #.... ..... ....# ..... .#..# ..... #.... ..... ..... #.... ..#.. ..... ..... ..... .....",
         ".###. #.##. .###. .##.# .###. .#... .#### #.##. .##.. ..##. #..#. ..#.. ##.#. #.##. .###. ####.",
         "....# ##..# #.... #..## #...# ###.. #...# ##..# ..#.. ...#. #.#.. ..#.. #.#.# ##..# #...# #...#",
         ".#### #...# #.... #...# ##### .#... #...# #...# ..#.. ...#. ##... ..#.. #.#.# #...# #...# #...#",
         "#...# #...# #...# #...# #.... .#... .#### #...# ..#.. ...#. #.#.. ..#.. #.#.# #...# #...# ##..#",
         ".#### ####. .###. .#### .###. .#... ....# #...# .###. ...#. #..#. .###. #...# #...# .###. #.##.",
         "..... ..... ..... ..... ..... ..... ....# ..... ..... #..#. ..... ..... ..... ..... ..... #....",
         "..... ..... ..... ..... ..... ..... .###. ..... ..... .##.. ..... ..... ..... ..... ..... #...."}}},
    {"qrstuvwxyz<>",
     {{
         "..... ..... ..... .#... ..... ..... ..... ..... ..... ..... ...#. .#...",
         "..... ..... ..... .#... ..... ..... ..... ..... ..... ..... ..#.. ..#..",
         ".#### #.##. .#### ###.. #...# #...# #...# #...# #...# ##### .#... ...#.",
         "#...# ##..# #.... .#... #...# #...# #...# .#.#. #...# ...#. #.... ....#",
         "#...# #.... .###. .#... #...# #...# #.#.# ..#.. #...# ..#.. .#... ...#.",
         "#..## #.... ....# .#..# #..## .#.#. #.#.# .#.#. .#### .#... ..#.. ..#..",
         ".##.# #.... ####. ..##. .##.# ..#.. .#.#. #...# ....# ##### ...#. .#...",
         "....# ..... ..... ..... ..... ..... ..... ..... ....# ..... ..... .....",
         "....# ..... ..... ..... ..... ..... ..... ..... .###. ..... ..... ....."}}},
}};
// clang-format on

bool continues_a_character(char byte) {
  return (static_cast<unsigned char>(byte) & 0xC0u) == 0x80u;
}

// What is drawn of a text, one byte a glyph: UTF-8's later bytes are none.
std::string drawable(std::string_view text) {
  std::string kept;
  std::copy_if(text.begin(), text.end(), std::back_inserter(kept), [](char c) { return !continues_a_character(c); });
  return kept;
}

bool is_dot(char character, std::size_t x, std::size_t y) {
  if (character == ' ') return false;
  for (const GlyphRow& row : kGlyphs) {
    const std::size_t place = row.characters.find(character);
    if (place != std::string_view::npos) return row.dots[y][place * kGlyphAdvance + x] == '#';
  }
  return is_dot('?', x, y);
}

void fill_dot(Photograph& picture, std::int64_t left, std::int64_t top, std::uint32_t scale, const Rgb8& color) {
  const std::int64_t right = std::min<std::int64_t>(left + scale, picture.width);
  const std::int64_t bottom = std::min<std::int64_t>(top + scale, picture.height);
  for (std::int64_t y = std::max<std::int64_t>(top, 0); y < bottom; ++y) {
    for (std::int64_t x = std::max<std::int64_t>(left, 0); x < right; ++x) {
      std::copy(color.begin(), color.end(), picture.rgb.begin() + 3 * (y * picture.width + x));
    }
  }
}

}  // namespace

std::uint32_t text_width(std::string_view text, std::uint32_t scale) {
  const auto glyphs = static_cast<std::uint32_t>(drawable(text).size());
  return glyphs == 0 ? 0 : (glyphs * kGlyphAdvance - 1) * scale;
}

void draw_text(Photograph& picture, std::int64_t left, std::int64_t top, std::string_view text, std::uint32_t scale,
               const Rgb8& color) {
  for (const char character : drawable(text)) {
    for (std::size_t y = 0; y < kGlyphHeight; ++y) {
      for (std::size_t x = 0; x < kGlyphWidth; ++x) {
        if (!is_dot(character, x, y)) continue;
        fill_dot(picture, left + static_cast<std::int64_t>(x * scale), top + static_cast<std::int64_t>(y * scale),
                 scale, color);
      }
    }
    left += static_cast<std::int64_t>(kGlyphAdvance) * scale;
  }
}

}  // namespace lumatlas
