// SPDX-License-Identifier: GPL-3.0-or-later
// What photographs take: a texel of the renderer's texture array, and a pixel of a view in the store. Whoever
// allocates, bounds or reports those bytes takes them from here.
#pragma once

#include <cstdint>

namespace lumatlas {

// A texel of the texture array is sRGB colour with validity as alpha (GL_SRGB8_ALPHA8), which has coarser levels too,
// and depth in half precision whose sign tells rims (GL_R16F), which has none.
inline constexpr std::uint64_t kColorTexelBytes = 4;
inline constexpr std::uint64_t kDepthTexelBytes = 2;

// A pixel of a stored view in memory is colour (3), depth (a float), trust, validity and rim (1 each).
inline constexpr std::uint64_t kStoredPixelBytes = 3 + sizeof(float) + 1 + 1 + 1;

}  // namespace lumatlas
