// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/content_tag.h"

#include <zlib.h>

#include <array>
#include <cstdio>

namespace lumatlas {

std::string content_tag(std::span<const std::uint8_t> bytes) {
  const auto crc = crc32_z(0, bytes.data(), bytes.size());
  const auto adler = adler32_z(1, bytes.data(), bytes.size());
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%08lx%08lx", crc, adler);
  return text.data();
}

}  // namespace lumatlas
