// SPDX-License-Identifier: GPL-3.0-or-later
// Reads the headers of JPEG, PNG, WebP and OpenEXR files without decoding a pixel. It is our own code because the
// decoders tell too late: a progressive JPEG is allocated and decoded whole before its size can be asked for, and one
// that is cut off is filled up with grey.
#pragma once

#include <cstdint>
#include <istream>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "atlas/images/photograph.h"

namespace lumatlas {

// The fields of EXIF that lumatlas uses.
struct ExifNote {
  int orientation = 1;         // 1 to 8
  std::string make, model;     // the camera's; empty: not said
  double focal_length_mm = 0;  // 0: not said
  double focal_length_35mm = 0;
  std::optional<GpsPosition> gps;
};
// Returns `note` with what `tiff` says. It is the TIFF structure of EXIF, and may hold any bytes.
[[nodiscard]] ExifNote read_exif(std::string_view tiff, ExifNote note = {});

struct JpegHeader {
  std::uint32_t width = 0;   // pixels, as stored
  std::uint32_t height = 0;  // pixels, as stored
  ExifNote exif;
};

// Returns nothing if there is no frame header before the first scan.
[[nodiscard]] std::optional<JpegHeader> read_jpeg_header(std::istream& file);

struct ImageExtent {
  std::uint32_t width, height;  // pixels
};
// Returns the size of the picture, or of the canvas of a file that may have several. Returns nothing if the first chunk
// holds no size.
[[nodiscard]] std::optional<ImageExtent> read_webp_size(std::istream& file);

// Returns whether a PNG file is whole up to its first pixels, with the checksums that it must have. libpng would print
// damage to the terminal, besides telling its caller.
[[nodiscard]] bool png_header_is_sound(std::istream& file);

// Returns whether all compressed pixels in `bytes`, a complete PNG file, have their checksums; for the same reason.
[[nodiscard]] bool png_pixels_are_sound(std::span<const std::uint8_t> bytes);

// The sizes that the decoder of an OpenEXR file allocates for. If the file has several pictures, each value is the
// largest.
struct ExrHeader {
  std::uint64_t width = 0, height = 0;  // pixels
  std::uint64_t columns = 0, rows = 0;  // the size of a tile, or of the lines that are compressed together
  std::uint64_t pixel_bytes = 0;        // bytes of a pixel with all its channels
};
// Returns nothing unless every attribute in the headers is as small as the rest of its `file_bytes`, and as large as
// its type. The decoder allocates what an attribute claims before it reads it. It reads channels, previews and numbers
// without checking their size, so it could take anything for the next attribute.
[[nodiscard]] std::optional<ExrHeader> read_exr_header(std::istream& file, std::uint64_t file_bytes);

// Returns whether the file in `bytes` reaches its end marker. Padding and further pictures may follow the marker.
[[nodiscard]] bool jpeg_is_complete(std::span<const std::uint8_t> bytes);
[[nodiscard]] bool png_is_complete(std::span<const std::uint8_t> bytes);

}  // namespace lumatlas
