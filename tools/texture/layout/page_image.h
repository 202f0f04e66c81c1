// SPDX-License-Identifier: GPL-3.0-or-later
// The page of a texture as the bytes of a file.
#pragma once

#include <cstdint>
#include <vector>

#include "atlas/images/photograph.h"

namespace lumatlas {

// WebP takes less than half of JPEG's bytes, with colour at half the resolution and at most 16383 texels a side.
enum class PageFormat { png, jpeg, webp };
[[nodiscard]] const char* ending(PageFormat format);     // a file name's ending: ".png"
[[nodiscard]] const char* mime_type(PageFormat format);  // "image/png"

inline constexpr std::uint32_t kLongestWebp = 16383;  // texels a side

struct PageCoding {
  PageFormat format = PageFormat::png;
  int quality = 95;  // for JPEG and WebP, [1, 100]; PNG is exact
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const PageCoding& coding);

// 8-bit RGB. The same bytes each time. Throws std::invalid_argument for what is no image, InputError if it cannot be
// encoded.
[[nodiscard]] std::vector<std::uint8_t> encode_page(const Photograph& page, const PageCoding& coding);

}  // namespace lumatlas
