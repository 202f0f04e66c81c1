// SPDX-License-Identifier: GPL-3.0-or-later
// Colours between the pixels of a photograph.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>

#include "atlas/images/photograph.h"

namespace lumatlas {

// The column that continues a picture beyond its first and its last one.
enum class AtEdges {
  clamp,  // the same column again
  wrap,   // the other one, as in a panorama
};

// Writes the colour at a place, in pixels with (0, 0) at the picture's corner, bilinear; beyond the first and the last
// row these are repeated. Returns false, and writes nothing, where a pixel that has a share in it is masked.
[[nodiscard]] bool resample(const Photograph& photograph, const glm::dvec2& place, AtEdges columns, std::uint8_t* rgb);

}  // namespace lumatlas
