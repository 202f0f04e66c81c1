// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: 4 x 4 texels in 16 bytes of BC7, also named BPTC, in two of its eight modes. Mode 6 has a ramp of
// 16 steps for colour and alpha together; mode 4, for blocks in which they change apart, one of 4 steps for colour and
// one of 8 for alpha. Source: the Khronos Data Format Specification, section "BPTC Compressed Texture Image Formats".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace lumatlas {

inline constexpr std::size_t kBc7BlockTexels = 16;
inline constexpr std::size_t kBc7BlockBytes = 16;

// Red, green, blue and alpha of each texel, row by row.
using BlockTexels = std::array<std::array<std::uint8_t, 4>, kBc7BlockTexels>;
using Bc7Block = std::array<std::uint8_t, kBc7BlockBytes>;

// Near the least sum of squared errors of all channels. An alpha of 0 stays 0 and no other becomes 0, so that a 1
// beside 0 and 255 becomes 36, the least step between them; one alpha for all 16 texels stays what it is.
[[nodiscard]] Bc7Block bc7_block(const BlockTexels& texels);

// Exactly what a GPU shows. Throws std::invalid_argument for a block of a mode that bc7_block() does not use.
[[nodiscard]] BlockTexels texels_of(std::span<const std::uint8_t, kBc7BlockBytes> block);

}  // namespace lumatlas
