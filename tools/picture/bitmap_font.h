// SPDX-License-Identifier: GPL-3.0-or-later
// Letters for legends in pictures: five dots wide and seven high, two below the line. No library, no font file.
#pragma once

#include <cstdint>
#include <string_view>

#include "atlas/images/photograph.h"
#include "tools/score/report/color_map.h"

namespace lumatlas {

inline constexpr std::uint32_t kGlyphAdvance = 6;  // dots from one letter to the next
inline constexpr std::uint32_t kGlyphHeight = 9;   // dots

// Each dot is a square of `scale` >= 1 pixels.
[[nodiscard]] std::uint32_t text_width(std::string_view text, std::uint32_t scale);

// The text's top left corner is at (left, top); what lies outside of the picture is cut off. Letters, digits, space and
// . , : - + = _ / ( ) % < > ?; any other byte becomes '?', of a character of several bytes the first alone.
void draw_text(Photograph& picture, std::int64_t left, std::int64_t top, std::string_view text, std::uint32_t scale,
               const Rgb8& color);

}  // namespace lumatlas
