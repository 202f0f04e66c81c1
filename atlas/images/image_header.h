// SPDX-License-Identifier: GPL-3.0-or-later
// What JPEG, PNG, WebP and OpenEXR files say of themselves, read without decoding a pixel. It is our own code because
// the decoders tell too late: a progressive JPEG is allocated and decoded whole before its size can be asked for, and
// one that is cut off is filled up with grey.
#pragma once

#include <cstdint>
#include <istream>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "atlas/images/photograph.h"

namespace lumatlas {

// What EXIF says of a photograph.
struct ExifNote {
  int orientation = 1;         // 1 to 8
  std::string make, model;     // of the camera; empty: not said
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

// Nothing if there is no frame header before the first scan.
[[nodiscard]] std::optional<JpegHeader> read_jpeg_header(std::istream& file);

struct ImageExtent {
  std::uint32_t width, height;  // pixels
};
// Of the picture, or of the canvas of a file that may have several. Nothing if the first chunk holds no size.
[[nodiscard]] std::optional<ImageExtent> read_webp_size(std::istream& file);

// Whether a PNG file is whole up to its first pixels, with the checksums that it must have: libpng tells the terminal,
// and not only its caller, when it comes upon damage.
[[nodiscard]] bool png_header_is_sound(std::istream& file);

// Whether all compressed pixels in `bytes`, a PNG file that is complete, have their checksums; for the same reason.
[[nodiscard]] bool png_pixels_are_sound(std::span<const std::uint8_t> bytes);

// What the decoder of an OpenEXR file allocates for; of several pictures in it, the largest of each.
struct ExrHeader {
  std::uint64_t width = 0, height = 0;  // pixels
  std::uint64_t columns = 0, rows = 0;  // of a tile, or of the lines that are compressed together
  std::uint64_t pixel_bytes = 0;        // of all channels
};
// Nothing unless every attribute in the headers is as small as the rest of its `file_bytes`, and as large as its type:
// the decoder allocates what an attribute claims before it reads it, and reads channels, previews and numbers without
// a look at their size, so that what it takes for the next attribute could be anything.
[[nodiscard]] std::optional<ExrHeader> read_exr_header(std::istream& file, std::uint64_t file_bytes);

// Whether the whole file in `bytes` reaches its end marker. What follows that marker (padding, further pictures) is
// free.
[[nodiscard]] bool jpeg_is_complete(std::span<const std::uint8_t> bytes);
[[nodiscard]] bool png_is_complete(std::span<const std::uint8_t> bytes);

}  // namespace lumatlas
