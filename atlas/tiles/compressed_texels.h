// SPDX-License-Identifier: GPL-3.0-or-later
// Texels in blocks that a GPU reads as they are: BC7, also named BPTC, of OpenGL 4.2. See atlas/tiles/bc7_block.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "atlas/images/image_levels.h"
#include "atlas/tiles/tiles.h"

namespace lumatlas {

inline constexpr std::uint32_t kBlockSide = 4;  // texels
inline constexpr std::size_t kBlockBytes = 16;

// Returns the blocks row by row from the top left. The same texels always give the same blocks. A validity of 0 stays 0
// and no other becomes 0: see bc7_block(). Throws std::invalid_argument unless the level's sides are multiples of 4.
[[nodiscard]] std::vector<std::uint8_t> compressed(const ImageLevel& level);
// Returns the texels that a GPU shows for these blocks. Throws std::invalid_argument unless the sides are multiples of
// 4, there are as many blocks as they have, and compressed() can have made each of them.
[[nodiscard]] ImageLevel decompressed(std::uint32_t width, std::uint32_t height, std::span<const std::uint8_t> blocks);

// The `levels` finest levels of a whole view with the colours that the texture array shows in this layout: rounded up
// to a multiple of 2^(levels - 1) pixels. `levels` must be in [1, levels_of(layout)] and the layout pass check()
// (std::invalid_argument).
[[nodiscard]] std::vector<ImageLevel> shown_levels(const StoredView& view, const TileOptions& layout,
                                                   std::uint32_t levels);

}  // namespace lumatlas
