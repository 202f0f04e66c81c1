// SPDX-License-Identifier: GPL-3.0-or-later
// Tells contents apart without keeping them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace lumatlas {

// 64 bits of the bytes, the same on every machine: XXH64. Different bytes have the same digest by chance only, once in
// 2^64; somebody may find such bytes on purpose.
[[nodiscard]] std::uint64_t content_digest(std::span<const std::byte> bytes);

// The digest as 16 hexadecimal digits, for the names of files.
[[nodiscard]] std::string content_digits(std::span<const std::byte> bytes);

}  // namespace lumatlas
