// SPDX-License-Identifier: GPL-3.0-or-later
// Sizes of a photograph's data: a texel of the renderer's texture array, and a pixel of a view in the store. All code
// that allocates, bounds or reports these bytes takes the sizes from here.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace lumatlas {

// Format in which the texture array holds sRGB colour, and validity as its alpha, on all levels.
enum class TexelFormat : std::uint8_t {
  rgb8,  // 8 bits a channel (GL_SRGB8_ALPHA8)
  bc7,   // blocks of 4 x 4 texels, see compressed_texels.h (GL_COMPRESSED_SRGB_ALPHA_BPTC_UNORM)
};

inline const std::map<std::string, TexelFormat> kTexelFormatsByName{{"rgb8", TexelFormat::rgb8},
                                                                    {"bc7", TexelFormat::bc7}};
[[nodiscard]] constexpr const char* name_of(TexelFormat format) {
  return format == TexelFormat::bc7 ? "bc7" : "rgb8";
}

// Returns the bytes of `texels` texels, in whole blocks where the format has blocks.
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
// Returns the number of blocks along a side of `side_px` pixels.
[[nodiscard]] constexpr std::uint32_t depth_blocks(std::uint32_t side_px) {
  return (side_px + kDepthBlockSide - 1) / kDepthBlockSide;
}

// A pixel of a stored view in memory is colour (3), depth (a float), trust, validity and rim (1 each).
inline constexpr std::uint64_t kStoredPixelBytes = 3 + sizeof(float) + 1 + 1 + 1;

}  // namespace lumatlas
