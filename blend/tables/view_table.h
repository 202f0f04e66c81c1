// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: the stored views' cameras and gains as the shaders read them.
#pragma once

#include <cstdint>
#include <glm/vec4.hpp>
#include <vector>

#include "atlas/snapshot.h"
#include "blend/tables/array_contents.h"

namespace lumatlas {

// Texels of each view; shared with the shaders.
inline constexpr std::uint32_t kViewTexels = 6;
// Tiles that the shaders tell apart: they divide the numbers of tiles as floats.
inline constexpr std::uint32_t kMostTiles = 1u << 21;
// Texels of views that the uniform block of every driver holds: 16 KB. Shared with the shaders.
inline constexpr std::uint32_t kBlockTexels = 1024;

// Returns the table that shaders/tables.glsl reads, by view slot. Slots without a view have zeros. Throws GlError for
// more than kMostTiles tiles.
[[nodiscard]] std::vector<glm::vec4> view_table(const Snapshot& snapshot, const ArrayContents& photographs);

}  // namespace lumatlas
