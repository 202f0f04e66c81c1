// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers by pixel, for files that hold them as they are.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace lumatlas {

// Row by row from the top left, the channels of a pixel side by side.
struct FloatImage {
  std::uint32_t width = 0;            // pixels
  std::uint32_t height = 0;           // pixels
  std::vector<std::string> channels;  // their names, as programs that read OpenEXR know them: R, G, B, Y, Z
  std::vector<float> values;          // width * height * channels; may be infinite, or NaN for no value
};

// OpenEXR, 32-bit floats. Writes beside `path`, then renames. Throws InputError where the file cannot be written,
// std::invalid_argument for an ending other than .exr, an image whose size is not in [1, 65536] or not that of its
// values, and channels without a name of their own of 1 to 255 bytes.
void write_float_image(const std::filesystem::path& path, const FloatImage& image);

}  // namespace lumatlas
