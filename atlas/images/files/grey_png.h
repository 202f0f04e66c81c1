// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: masks as PNG files of one grey channel, in half the bytes that encode_image() takes for them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace lumatlas {

// The time that may go into a small file: `least` for one that is fetched once, from the same machine.
enum class PngEffort { least, most };

// Returns the bytes of a PNG file with one value per pixel, row by row. The same bytes for the same input. Throws
// std::invalid_argument unless there are width x height values, at least one.
[[nodiscard]] std::vector<std::uint8_t> grey_png(std::span<const std::uint8_t> values, std::uint32_t width,
                                                 std::uint32_t height, PngEffort effort = PngEffort::most);

}  // namespace lumatlas
