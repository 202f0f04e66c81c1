// SPDX-License-Identifier: GPL-3.0-or-later
// A short text that says which bytes a file holds, for its name.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace lumatlas {

// 16 hexadecimal digits: zlib's CRC-32 and its Adler-32. Versions of a file that differ have different tags but for one
// pair in some 2^60, unless somebody makes them so.
[[nodiscard]] std::string content_tag(std::span<const std::uint8_t> bytes);

}  // namespace lumatlas
