// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/content_digest.h"

#include <OpenImageIO/hash.h>

#include <array>
#include <charconv>

namespace lumatlas {

std::uint64_t content_digest(std::span<const std::byte> bytes) {
  return OIIO::xxhash::XXH64(bytes.data(), bytes.size(), 0);
}

std::string content_digits(std::span<const std::byte> bytes) {
  std::array<char, 16> digits{};
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), content_digest(bytes), 16);
  const std::string written(digits.data(), end);
  return std::string(digits.size() - written.size(), '0') + written;
}

std::string name_by_content(const std::string& stem, const std::string& ending, std::span<const std::uint8_t> bytes) {
  return stem + "-" + content_digits(std::as_bytes(bytes)) + ending;
}

}  // namespace lumatlas
