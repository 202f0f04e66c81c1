// SPDX-License-Identifier: GPL-3.0-or-later
// What photographs take: a texel of the renderer's texture array, and a pixel of a view in the store. Whoever
// allocates, bounds or reports those bytes takes them from here.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace lumatlas {

// How the texture array holds sRGB colour, and validity as its alpha. Coarser levels are held alike.
enum class TexelFormat : std::uint8_t {
  rgb8,  // 8 bits a channel (GL_SRGB8_ALPHA8)
  bc7,   // blocks of 4 x 4 texels, see compressed_texels.h (GL_COMPRESSED_SRGB_ALPHA_BPTC_UNORM)
};

inline const std::map<std::string, TexelFormat> kTexelFormatsByName{{"rgb8", TexelFormat::rgb8},
                                                                    {"bc7", TexelFormat::bc7}};
[[nodiscard]] constexpr const char* name_of(TexelFormat format) {
  return format == TexelFormat::bc7 ? "bc7" : "rgb8";
}

// Bytes of so many texels; of whole blocks in formats that have them.
[[nodiscard]] constexpr std::uint64_t color_bytes(TexelFormat format, std::uint64_t texels) {
  return format == TexelFormat::bc7 ? texels / 2 : 3 * texels;
}
[[nodiscard]] constexpr std::uint64_t validity_bytes(TexelFormat format, std::uint64_t texels) {
  return format == TexelFormat::bc7 ? texels / 2 : texels;
}

// Depth beside them is in blocks of 8 x 8 pixels (GL_RGBA32UI), see depth_blocks.h: of tiles without their gutters,
// and without coarser levels.
inline constexpr std::uint32_t kDepthBlockSide = 8;
inline constexpr std::uint64_t kDepthBlockBytes = 16;
// Blocks along a side of so many pixels.
[[nodiscard]] constexpr std::uint32_t depth_blocks(std::uint32_t side_px) {
  return (side_px + kDepthBlockSide - 1) / kDepthBlockSide;
}

// A pixel of a stored view in memory is colour (3), depth (a float), trust, validity and rim (1 each).
inline constexpr std::uint64_t kStoredPixelBytes = 3 + sizeof(float) + 1 + 1 + 1;

}  // namespace lumatlas
