// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: the stored views' cameras and gains as the shaders read them.
#pragma once

#include <cstdint>
#include <glm/vec4.hpp>
#include <vector>

#include "atlas/snapshot.h"
#include "blend/gl/photograph_array.h"

namespace lumatlas {

// Texels of each view; shared with the shaders.
inline constexpr std::uint32_t kViewTexels = 6;

// Returns the table that shaders/tables.glsl reads, by view slot. Slots without a view have zeros. Throws GlError for
// more tiles than a float counts.
[[nodiscard]] std::vector<glm::vec4> view_table(const Snapshot& snapshot, const PhotographArray& photographs);

}  // namespace lumatlas
