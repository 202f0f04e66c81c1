// SPDX-License-Identifier: GPL-3.0-or-later
// Draws text on pictures with the font of stb_easy_font.h, which needs no font file.
#pragma once

#include <cstdint>
#include <string_view>

#include "atlas/images/photograph.h"
#include "tools/score/report/color_map.h"

namespace lumatlas {

inline constexpr std::uint32_t kGlyphHeight = 9;  // dots: seven above the line, two below

// Returns the width of the text in pixels. Each dot is a square of `scale` >= 1 pixels.
[[nodiscard]] std::uint32_t text_width(std::string_view text, std::uint32_t scale);

// Draws the text with its top left corner at (left, top), and cuts off what lies outside the picture. Each character
// other than the printable ones of ASCII becomes one '?', however many bytes of UTF-8 it has.
void draw_text(Photograph& picture, std::int64_t left, std::int64_t top, std::string_view text, std::uint32_t scale,
               const Rgb8& color);

}  // namespace lumatlas
