// SPDX-License-Identifier: GPL-3.0-or-later
// The pixels of a JPEG file, by libjpeg itself: OpenImageIO 2.4 hides its warnings, and those tell of damage within the
// coded data, which has no checksum.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "atlas/images/photograph.h"

namespace lumatlas {

struct JpegPixels {
  std::vector<std::uint8_t> rgb;      // 3 * width * height
  std::vector<std::uint8_t> profile;  // the ICC profile of the file's colours; empty: it has none, or a damaged one
};

// The pixels as stored, row by row from the top, whatever EXIF says of the orientation; grey and CMYK
// become RGB. `path` stands for the bytes in sentences; the caller has found in their header that they are of this size
// and that it is a plausible one. Throws InputError if they are not of this size, and for damage that the decoder
// meets: coded data that no encoder wrote, that ends before the picture is full, or of which something is left over.
// Changed bits that still decode to as many blocks go unnoticed.
[[nodiscard]] JpegPixels decode_jpeg(std::span<const std::uint8_t> bytes, const std::filesystem::path& path,
                                     std::uint32_t width, std::uint32_t height);

// Decodes the same pixels a few rows at a time and hands each band of rows to `use`, from the top. Holds one band in
// memory. Does nothing but return false if the file has an ICC profile. Throws as decode_jpeg(); bands that came before
// have then been handed on.
[[nodiscard]] bool decode_jpeg_rows(std::span<const std::uint8_t> bytes, const std::filesystem::path& path,
                                    std::uint32_t width, std::uint32_t height, const PixelRows& use);

}  // namespace lumatlas
