// SPDX-License-Identifier: GPL-3.0-or-later
// Selects the pixels of a held-out view that count: the conventions of scores.h in one place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "atlas/images/photograph.h"

namespace lumatlas {

// One entry per pixel, row by row: 1 where it counts, 0 elsewhere.
using CountedPixels = std::vector<std::uint8_t>;

// Throws std::invalid_argument unless the pictures have one size of at least a pixel, complete data, and a mask of that
// size or none.
[[nodiscard]] CountedPixels counted_pixels(const Photograph& rendering, const Photograph& photograph,
                                           std::span<const std::uint8_t> mask);

// Throws std::invalid_argument saying what has `size` entries and how many it must have.
void check_entries(const char* what, std::size_t size, std::size_t expected);

}  // namespace lumatlas
