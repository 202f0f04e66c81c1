// SPDX-License-Identifier: GPL-3.0-or-later
// Tells contents apart without keeping them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace lumatlas {

// Returns the XXH64 digest of the bytes, the same on every machine. Two different inputs have the same digest with a
// probability of 2^-64, unless they were made to: XXH64 does not withstand an attacker.
[[nodiscard]] std::uint64_t content_digest(std::span<const std::byte> bytes);

// The digest as 16 hexadecimal digits, for the names of files.
[[nodiscard]] std::string content_digits(std::span<const std::byte> bytes);

// Returns "STEM-DIGEST.ENDING". Files of one name have the same bytes, so that a reader which is still at an earlier
// model never meets a file of a later one, and no cache takes one for another.
[[nodiscard]] std::string name_by_content(const std::string& stem, const std::string& ending,
                                          std::span<const std::uint8_t> bytes);

}  // namespace lumatlas
