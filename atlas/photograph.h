// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs: 8-bit sRGB in memory, whatever the file held.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace lumatlas {

// Row by row from the top left.
struct Photograph {
  std::uint32_t width = 0;          // pixels
  std::uint32_t height = 0;         // pixels
  std::vector<std::uint8_t> rgb;    // sRGB, 3 * width * height
  std::vector<std::uint8_t> valid;  // 0: outside the lens's image (undistortion border), 255: inside; empty: all inside
};

// What to do about an EXIF orientation. Photographs are upright by it for people to look at; but a
// structure-from-motion program that ignored it (COLMAP does) has calibrated the pixels as they are stored.
enum class Orientation { exif, as_stored };

// Width and height from the header alone. Throws InputError.
struct ImageSize {
  std::uint32_t width, height;
};
[[nodiscard]] ImageSize photograph_size(const std::filesystem::path& path, Orientation orientation = Orientation::exif);

// 8 and 16 bit, grey and colour, with or without alpha (alpha is dropped); floating-point files are taken as linear
// light. Throws InputError: path and reason, also for a truncated file.
[[nodiscard]] Photograph read_photograph(const std::filesystem::path& path,
                                         Orientation orientation = Orientation::exif);

// PNG, 8-bit RGB, or by the ending another format that OpenImageIO writes. Writes beside `path`, then renames.
void write_image(const std::filesystem::path& path, const Photograph& image);

}  // namespace lumatlas
