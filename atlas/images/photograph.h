// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs: 8-bit sRGB in memory, whatever the file held.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace lumatlas {

// Row by row from the top left.
struct Photograph {
  std::uint32_t width = 0;          // pixels
  std::uint32_t height = 0;         // pixels
  std::vector<std::uint8_t> rgb;    // sRGB, 3 * width * height
  std::vector<std::uint8_t> valid;  // 0: outside the lens's image (undistortion border), 255: inside; empty: all inside
};

// A photograph whose pixels something else keeps. The lists are as Photograph's.
struct PhotographSpan {
  std::uint32_t width = 0;   // pixels
  std::uint32_t height = 0;  // pixels
  std::span<const std::uint8_t> rgb;
  std::span<const std::uint8_t> valid;

  PhotographSpan() = default;
  PhotographSpan(const Photograph& photograph)  // NOLINT(google-explicit-constructor): as a std::span of a vector
      : width(photograph.width), height(photograph.height), rgb(photograph.rgb), valid(photograph.valid) {}
  PhotographSpan(Photograph&&) = delete;  // it would be gone
};

// The treatment of an EXIF orientation. Viewers turn photographs upright by it. A structure-from-motion program that
// ignores it, as COLMAP does, has calibrated the pixels as they are stored.
enum class Orientation { exif, as_stored };

struct ImageSize {
  std::uint32_t width, height;  // pixels
};
// Reads the size from the header alone. Throws InputError.
[[nodiscard]] ImageSize photograph_size(const std::filesystem::path& path, Orientation orientation = Orientation::exif);

// The position of a photograph as its satellite receiver states it: WGS 84.
struct GpsPosition {
  double latitude_deg = 0;   // [-90, 90], north is positive
  double longitude_deg = 0;  // [-180, 180], east is positive
  double altitude_m = 0;     // 0 where the file does not say

  friend bool operator==(const GpsPosition&, const GpsPosition&) = default;
};

// The camera that took a photograph, as the file's header describes it.
struct CameraNote {
  ImageSize size;                  // as it is stored
  std::string make, model;         // empty: not said
  double focal_length_mm = 0;      // 0: not said
  double focal_length_35mm = 0;    // that a camera for 35 mm film would need for the same view; 0: not said
  std::optional<GpsPosition> gps;  // none: not said
};
// Reads the header of a file that read_photograph() reads. Throws InputError.
[[nodiscard]] CameraNote read_camera_note(const std::filesystem::path& path);

// Reads JPEG, PNG, TIFF, WebP, OpenEXR, HEIC (HEIF), AVIF, and the raw forms of cameras that LibRaw knows (DNG, CR2,
// CR3, NEF, ARW, RAF, ORF, RW2 and others). Formats are recognised by the first bytes, whatever the name, and a raw
// TIFF by its directories; other formats are refused. 8 and 16 bit, grey and colour, with or without alpha (alpha is
// dropped); floating-point files are taken as linear light. Colours in the space of an ICC profile, such as Display P3
// or Adobe RGB, are converted to sRGB. HEIC, AVIF and raw files are turned once, by their decoders, whatever
// `orientation` is: other programs see them through the same decoders. A raw file is developed as picture_file.h says.
// Its size is what LibRaw finds visible, which may be some pixels more than the camera's own JPEG has. A file that is
// replaced by another one while it is read gives the old picture or the new one. Throws InputError: path and reason,
// also for a file that is cut off or whose coded pixels are damaged, as far as its decoder can tell.
[[nodiscard]] Photograph read_photograph(const std::filesystem::path& path,
                                         Orientation orientation = Orientation::exif);

// Takes rows of pixels, three values of sRGB each, from the row `first_row` on.
using PixelRows = std::function<void(std::uint32_t first_row, std::span<const std::uint8_t> rgb)>;

// Reads the same pixels, upright, and hands them to `use` in bands of rows from the top. Of a JPEG or PNG that is
// neither turned nor of another colour space than sRGB it holds a band in memory, of other files all pixels. Throws as
// read_photograph() does, before or between calls of `use`. Returns the size.
ImageSize read_photograph_rows(const std::filesystem::path& path, const PixelRows& use);
ImageSize read_photograph_rows(std::span<const std::uint8_t> file, const std::string& name, const PixelRows& use);

// The alpha of each pixel of a file that read_photograph() reads, 0 to 255; empty where the file has none. Throws
// InputError.
[[nodiscard]] std::vector<std::uint8_t> read_alpha(const std::filesystem::path& path,
                                                   Orientation orientation = Orientation::exif);

// A picture of whole numbers, such as depths, as it is stored, row by row from the top left.
struct GreyImage {
  std::uint32_t width = 0, height = 0;  // pixels
  std::vector<std::uint16_t> values;    // width * height
};

// A PNG or TIFF file of one channel of 16 bits. Throws InputError, also for another one, whose numbers
// would be other ones.
[[nodiscard]] GreyImage read_grey_image(const std::filesystem::path& path);

// Size and pixels of a PNG or JPEG file in memory, upright; `name` stands for its path in sentences.
[[nodiscard]] ImageSize photograph_size(std::span<const std::uint8_t> file, const std::string& name);
[[nodiscard]] Photograph read_photograph(std::span<const std::uint8_t> file, const std::string& name);

enum class ImageFormat { png, jpeg, webp };
[[nodiscard]] const char* ending(ImageFormat format);     // a file name's ending: ".png"
[[nodiscard]] const char* mime_type(ImageFormat format);  // "image/png"

struct ImageCoding {
  ImageFormat format = ImageFormat::png;
  int quality = 95;  // for JPEG and WebP, [1, 100]; PNG is exact
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const ImageCoding& coding);

// Returns the bytes of a file, 8-bit RGB. JPEG keeps colour at full resolution, so that it does not bleed. The result
// is deterministic. The file's EXIF has the camera and position of the note, if there is one. Throws
// std::invalid_argument for an invalid image, InputError if it cannot be encoded.
[[nodiscard]] std::vector<std::uint8_t> encode_image(const Photograph& image, const ImageCoding& coding,
                                                     const std::optional<CameraNote>& note = std::nullopt);

// Returns the bytes of a PNG file of one channel of 16 bits, made in little time. Throws std::invalid_argument for an
// invalid image, InputError if it cannot be encoded.
[[nodiscard]] std::vector<std::uint8_t> encode_grey_image(const GreyImage& image);

// Writes a PNG file, 8-bit RGB, or by the ending another format that OpenImageIO writes. `alpha` is empty, or has one
// value for each pixel, 255 is opaque. Writes beside `path`, then renames. Throws std::invalid_argument for what is no
// image, InputError naming the path unless every byte was taken; waits for no disk, see Durability::left_to_folder.
void write_image(const std::filesystem::path& path, const Photograph& image, std::span<const std::uint8_t> alpha = {});

}  // namespace lumatlas
