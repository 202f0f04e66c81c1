// SPDX-License-Identifier: GPL-3.0-or-later
// Measures how far each pixel is from the nearest one that must not be used.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace lumatlas {

// Returns one value per pixel, row by row: 0 where `good` is 0, else the distance in pixels to the nearest such pixel
// or to the first one beyond the image's border. Distances are along rows, columns and diagonals: up to 8 % more than
// along a straight line. G. Borgefors, "Distance transformations in digital images", 1986.
[[nodiscard]] std::vector<float> edge_distances(std::span<const std::uint8_t> good, std::uint32_t width,
                                                std::uint32_t height);

}  // namespace lumatlas
