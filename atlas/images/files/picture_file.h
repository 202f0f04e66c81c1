// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: photographs that a decoder of their own reads, and not OpenImageIO.
#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>
#include <memory>
#include <string_view>
#include <vector>

#include "atlas/images/files/image_header.h"

namespace lumatlas {

struct PicturePixels {
  ImageExtent size;
  std::vector<std::uint8_t> rgb;      // 3 * width * height, row by row from the top left
  std::vector<std::uint8_t> alpha;    // width * height; empty: there is none
  std::vector<std::uint8_t> profile;  // the ICC profile of the colours; empty: they are sRGB
};

// An open file. One thread at a time; threads may decode different ones at once.
class PictureFile {
 public:
  PictureFile() = default;
  virtual ~PictureFile() = default;
  PictureFile(const PictureFile&) = delete;
  PictureFile& operator=(const PictureFile&) = delete;

  // The picture's size, in pixels, with the turns and crops that the decoder carries out itself. The orientation that
  // is still to be carried out is always 1.
  [[nodiscard]] virtual ImageExtent size() const = 0;
  [[nodiscard]] virtual std::uint64_t decoder_bytes() const = 0;  // about as much as decode() allocates
  [[nodiscard]] virtual ExifNote exif() const = 0;                // its orientation means nothing

  // Throws InputError for a damaged picture, as far as the decoder can tell. A second call is not allowed.
  [[nodiscard]] virtual PicturePixels decode() = 0;
};

// HEIC, HEIF and AVIF, by libheif: OpenImageIO 2.4 ends the program at a picture that is smaller than its file claims,
// and hands over no profile. Ten and twelve bits become eight; colours of an HDR transfer function (PQ, HLG) are taken
// as they are coded. Throws InputError.
[[nodiscard]] std::unique_ptr<PictureFile> open_heif(const std::filesystem::path& path);

// The raw form of a camera, by LibRaw: OpenImageIO 2.4 hides the damage that LibRaw reports. Develops it to sRGB with
// the camera's white balance, and without what depends on the picture's content, so that photographs of one series
// agree. There is no tone curve, so that it is mostly darker than the camera's own JPEG. Throws InputError.
[[nodiscard]] std::unique_ptr<PictureFile> open_raw(const std::filesystem::path& path);

// Returns whether a file that begins with `head`, TIFF or not, is a camera's raw format.
[[nodiscard]] bool is_raw(std::string_view head, std::istream& file);

}  // namespace lumatlas
