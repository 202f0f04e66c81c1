// SPDX-License-Identifier: GPL-3.0-or-later
// Guesses the depth of pixels that see no surface from those around them that do.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace lumatlas {

// Returns an inverse depth for each pixel, row by row: that of the pixel where it is known, and elsewhere a smooth
// continuation from coarser and coarser means of the known ones (pull and push). The continuation is in inverse depth,
// in which planes are linear in the picture. A mean weights pixels by their squared depths: past the edge of an object,
// the surface behind it goes on, and not the object. `inverse_depth`: 0 where nothing is known, otherwise > 0, 1 /
// scene units. All 0 where nothing is known at all. Throws std::invalid_argument unless each pixel has a value.
[[nodiscard]] std::vector<double> filled_inverse_depth(std::span<const double> inverse_depth, std::uint32_t width,
                                                       std::uint32_t height);

}  // namespace lumatlas
