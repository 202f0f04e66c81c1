// SPDX-License-Identifier: GPL-3.0-or-later
// ITU-T T.81 (JPEG), annex B.1: markers and segments. JEITA CP-3451 (EXIF 2.32), 4.6.4 and 4.6.5: camera.
// W3C PNG, third edition, section 5: chunks; annex D: their checksum. OpenEXR file layout: headers, attributes.
// RFC 9649 (WebP), sections 2.5 to 2.7: the first chunk; RFC 6386 (VP8), section 9.1; WebP lossless, section 3.
#include "atlas/images/files/image_header.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace lumatlas {

namespace {

// The second byte of a JPEG marker; the first is 0xff.
enum Marker : int { kDht = 0xc4, kJpg = 0xc8, kDac = 0xcc, kRst0 = 0xd0, kEoi = 0xd9, kSos = 0xda, kApp1 = 0xe1 };

// Start of frame, of any of the thirteen coding processes.
bool is_frame(int marker) {
  return marker >= 0xc0 && marker <= 0xcf && marker != kDht && marker != kJpg && marker != kDac;
}

// A marker without a segment: start and end of image, restarts, TEM; and 0xff00, which is a byte of coded data.
bool stands_alone(int marker) {
  return marker <= 0x01 || (marker >= kRst0 && marker <= kEoi);
}

int read_u16(std::istream& file) {
  const int high = file.get();
  return high << 8 | file.get();
}

// The next marker after any fill bytes, or -1.
int next_marker(std::istream& file) {
  int byte = file.get();
  while (file && byte != 0xff) byte = file.get();
  while (file && byte == 0xff) byte = file.get();
  return file ? byte : -1;
}

// The TIFF structure inside an EXIF segment, in either byte order. What lies outside reads as 0.
class Exif {
 public:
  explicit Exif(std::string_view tiff) : tiff_(tiff), big_endian_(tiff.starts_with("MM")) {}

  [[nodiscard]] std::size_t u16(std::size_t at) const {
    return big_endian_ ? byte(at) << 8 | byte(at + 1) : byte(at + 1) << 8 | byte(at);
  }
  [[nodiscard]] std::size_t u32(std::size_t at) const {
    return big_endian_ ? u16(at) << 16 | u16(at + 2) : u16(at + 2) << 16 | u16(at);
  }
  // Returns `size` bytes from `at` on, fewer where the file ends before.
  [[nodiscard]] std::string_view text(std::size_t at, std::size_t size) const {
    return tiff_.substr(std::min(at, tiff_.size()), size);
  }

 private:
  [[nodiscard]] std::size_t byte(std::size_t at) const {
    return at < tiff_.size() ? static_cast<unsigned char>(tiff_[at]) : 0;
  }

  std::string_view tiff_;
  bool big_endian_;
};

// The text of an ASCII entry, without what follows its first zero.
std::string exif_text(const Exif& exif, std::size_t entry) {
  const std::size_t count = exif.u32(entry + 4);
  const std::string_view text = exif.text(count > 4 ? exif.u32(entry + 8) : entry + 8, count);
  return std::string(text.substr(0, text.find('\0')));
}

// Returns the place of the directory's first entry with this tag.
std::optional<std::size_t> exif_entry(const Exif& exif, std::size_t directory, std::size_t tag) {
  const std::size_t entries = exif.u16(directory);
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t entry = directory + 2 + 12 * i;
    if (exif.u16(entry) == tag) return entry;
  }
  return std::nullopt;
}

// Returns the RATIONAL at this place; nothing where it is divided by zero.
std::optional<double> exif_ratio(const Exif& exif, std::size_t at) {
  const std::size_t divisor = exif.u32(at + 4);
  if (divisor == 0) return std::nullopt;
  return static_cast<double>(exif.u32(at)) / static_cast<double>(divisor);
}

// Returns the angle in degrees of the entry `tag`, three RATIONALs of degrees, minutes and seconds. It is negative
// where the entry before it, the hemisphere, is `negative`. Nothing where either entry is missing or malformed.
std::optional<double> exif_angle(const Exif& exif, std::size_t directory, std::size_t tag, char negative) {
  const auto hemisphere = exif_entry(exif, directory, tag - 1), angle = exif_entry(exif, directory, tag);
  if (!hemisphere || !angle) return std::nullopt;
  constexpr std::array kUnits{1.0, 60.0, 3600.0};
  double degrees = 0;
  for (std::size_t i = 0; i < kUnits.size(); ++i) {
    const std::optional<double> part = exif_ratio(exif, exif.u32(*angle + 8) + 8 * i);
    if (!part) return std::nullopt;
    degrees += *part / kUnits[i];
  }
  return exif.text(*hemisphere + 8, 1) == std::string_view(&negative, 1) ? -degrees : degrees;
}

// Returns the place that the GPS directory tells; nothing unless it tells a latitude and a longitude on Earth.
std::optional<GpsPosition> exif_place(const Exif& exif, std::size_t directory) {
  constexpr std::size_t kLatitude = 2, kLongitude = 4, kBelowSea = 5, kAltitude = 6;
  const std::optional<double> latitude = exif_angle(exif, directory, kLatitude, 'S');
  const std::optional<double> longitude = exif_angle(exif, directory, kLongitude, 'W');
  if (!latitude || !longitude || std::abs(*latitude) > 90 || std::abs(*longitude) > 180) return std::nullopt;
  GpsPosition place{*latitude, *longitude, 0};
  if (const auto altitude = exif_entry(exif, directory, kAltitude)) {
    place.altitude_m = exif_ratio(exif, exif.u32(*altitude + 8)).value_or(0);
    const auto below = exif_entry(exif, directory, kBelowSea);
    if (below && exif.text(*below + 8, 1) == std::string_view("\1", 1)) place.altitude_m = -place.altitude_m;
  }
  return place;
}

std::uint32_t u32_big_endian(const std::uint8_t* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 | std::uint32_t{bytes[2]} << 8 | bytes[3];
}

std::uint32_t u32_little_endian(const std::array<std::uint8_t, 4>& bytes) {
  return std::uint32_t{bytes[3]} << 24 | std::uint32_t{bytes[2]} << 16 | std::uint32_t{bytes[1]} << 8 | bytes[0];
}

constexpr std::size_t kAroundData = 12;  // a PNG chunk's length, type and checksum

bool read_bytes(std::istream& file, std::span<std::uint8_t> bytes) {
  return static_cast<bool>(
      file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())));
}

// Returns whether the rest of a chunk, from its data on, is there and has the checksum of its type and data.
bool chunk_is_sound(std::istream& file, std::span<const std::uint8_t> type, std::uint32_t length) {
  uLong checksum = crc32(0, type.data(), static_cast<uInt>(type.size()));
  std::array<std::uint8_t, 4096> buffer{};
  while (length > 0) {
    const std::span part = std::span(buffer).first(std::min<std::size_t>(length, buffer.size()));
    if (!read_bytes(file, part)) return false;
    checksum = crc32(checksum, part.data(), static_cast<uInt>(part.size()));
    length -= static_cast<std::uint32_t>(part.size());
  }
  const std::span stored = std::span(buffer).first(4);
  return read_bytes(file, stored) && u32_big_endian(stored.data()) == checksum;
}

}  // namespace

ExifNote read_exif(std::string_view tiff, ExifNote note) {
  constexpr std::size_t kMake = 0x010f, kModel = 0x0110, kOrientation = 0x0112, kOwnDirectory = 0x8769,
                        kGpsDirectory = 0x8825, kFocal = 0x920a, kFocal35 = 0xa405;
  const Exif exif(tiff);
  const std::size_t directory = exif.u32(4);
  if (const auto make = exif_entry(exif, directory, kMake)) note.make = exif_text(exif, *make);
  if (const auto model = exif_entry(exif, directory, kModel)) note.model = exif_text(exif, *model);
  if (const auto orientation = exif_entry(exif, directory, kOrientation)) {
    const std::size_t value = exif.u16(*orientation + 8);
    if (value >= 1 && value <= 8) note.orientation = static_cast<int>(value);
  }
  if (const auto own = exif_entry(exif, directory, kOwnDirectory)) {
    const std::size_t details = exif.u32(*own + 8);
    if (const auto focal = exif_entry(exif, details, kFocal)) {
      note.focal_length_mm = exif_ratio(exif, exif.u32(*focal + 8)).value_or(note.focal_length_mm);
    }
    if (const auto focal = exif_entry(exif, details, kFocal35)) {
      note.focal_length_35mm = static_cast<double>(exif.u16(*focal + 8));
    }
  }
  if (const auto place = exif_entry(exif, directory, kGpsDirectory)) note.gps = exif_place(exif, exif.u32(*place + 8));
  return note;
}

std::optional<JpegHeader> read_jpeg_header(std::istream& file) {
  JpegHeader header;
  for (int marker = next_marker(file); marker >= 0 && marker != kSos; marker = next_marker(file)) {
    if (stands_alone(marker)) continue;
    const int length = read_u16(file) - 2;
    if (!file || length < 0) return {};
    if (is_frame(marker)) {
      file.get();  // bits per sample
      header.height = static_cast<std::uint32_t>(read_u16(file));
      header.width = static_cast<std::uint32_t>(read_u16(file));
      return file ? std::optional(header) : std::nullopt;
    }
    if (marker == kApp1) {
      std::string segment(static_cast<std::size_t>(length), '\0');
      file.read(segment.data(), length);
      constexpr std::string_view kExif("Exif\0\0", 6);
      if (segment.starts_with(kExif)) {
        header.exif = read_exif(std::string_view(segment).substr(kExif.size()), std::move(header.exif));
      }
    } else {
      file.seekg(length, std::ios::cur);
    }
  }
  return {};
}

std::optional<ImageExtent> read_webp_size(std::istream& file) {
  file.ignore(12);  // "RIFF", a length, "WEBP"
  std::array<std::uint8_t, 18> chunk{};
  if (!read_bytes(file, chunk)) return {};
  const std::uint8_t* const data = chunk.data() + 8;  // after its type and its length
  const auto u16 = [&](std::size_t at) { return std::uint32_t{data[at + 1]} << 8 | data[at]; };
  const auto u24 = [&](std::size_t at) { return std::uint32_t{data[at + 2]} << 16 | u16(at); };
  if (std::memcmp(chunk.data(), "VP8X", 4) == 0) return ImageExtent{u24(4) + 1, u24(7) + 1};
  if (std::memcmp(chunk.data(), "VP8L", 4) == 0 && data[0] == 0x2f) {
    const std::uint32_t bits = std::uint32_t{data[4]} << 24 | u24(1);
    return ImageExtent{(bits & 0x3fff) + 1, (bits >> 14 & 0x3fff) + 1};
  }
  if (std::memcmp(chunk.data(), "VP8 ", 4) == 0 && std::memcmp(data + 3, "\x9d\x01\x2a", 3) == 0) {
    return ImageExtent{u16(6) & 0x3fff, u16(8) & 0x3fff};
  }
  return {};
}

bool jpeg_is_complete(std::span<const std::uint8_t> bytes) {
  std::size_t at = 0;
  while (at + 1 < bytes.size()) {
    const void* const found = std::memchr(bytes.data() + at, 0xff, bytes.size() - 1 - at);
    if (!found) return false;
    at = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - bytes.data()) + 1;
    const int marker = bytes[at];
    if (marker == 0xff) continue;  // a fill byte
    if (marker == kEoi) return true;
    ++at;
    if (stands_alone(marker)) continue;
    if (at + 2 > bytes.size()) return false;
    at += static_cast<std::size_t>(bytes[at] << 8 | bytes[at + 1]);
  }
  return false;
}

bool png_header_is_sound(std::istream& file) {
  file.ignore(8);  // the signature
  std::array<std::uint8_t, 8> head{};
  for (bool first = true; read_bytes(file, head); first = false) {
    const std::uint32_t length = u32_big_endian(head.data());
    const std::span type = std::span(head).subspan(4);
    if (first != (std::memcmp(type.data(), "IHDR", 4) == 0)) return false;
    if (std::memcmp(type.data(), "IDAT", 4) == 0) return true;
    if (!chunk_is_sound(file, type, length)) return false;
  }
  return false;
}

bool png_pixels_are_sound(std::span<const std::uint8_t> bytes) {
  std::size_t at = 8;  // the signature
  while (at + kAroundData <= bytes.size()) {
    const std::size_t length = u32_big_endian(bytes.data() + at);
    if (length > bytes.size() - at - kAroundData) return false;
    const std::uint8_t* const type = bytes.data() + at + 4;
    if (std::memcmp(type, "IEND", 4) == 0) return true;
    const bool pixels = std::memcmp(type, "IDAT", 4) == 0;
    if (pixels && crc32_z(0, type, 4 + length) != u32_big_endian(type + 4 + length)) return false;
    at += kAroundData + length;
  }
  return false;
}

namespace {

// Attributes of OpenEXR whose values have one size; it reads them by their type, whatever size the file says.
constexpr std::array<std::pair<std::string_view, std::size_t>, 24> kFixedSizes{{
    {"box2f", 16},
    {"box2i", 16},
    {"chromaticities", 32},
    {"compression", 1},
    {"deepImageState", 1},
    {"double", 8},
    {"envmap", 1},
    {"float", 4},
    {"int", 4},
    {"keycode", 28},
    {"lineOrder", 1},
    {"m33d", 72},
    {"m33f", 36},
    {"m44d", 128},
    {"m44f", 64},
    {"rational", 8},
    {"tiledesc", 9},
    {"timecode", 8},
    {"v2d", 16},
    {"v2f", 8},
    {"v2i", 8},
    {"v3d", 24},
    {"v3f", 12},
    {"v3i", 12},
}};

std::uint32_t number_in(std::string_view value, std::size_t at) {
  std::array<std::uint8_t, 4> bytes{};
  std::memcpy(bytes.data(), value.data() + at, bytes.size());
  return u32_little_endian(bytes);
}

// Returns the bytes of all channels together. Nothing unless there are names that end with a zero, each with 16 bytes,
// and an empty name at the end.
std::optional<std::uint64_t> bytes_of_channels(std::string_view value) {
  constexpr std::size_t kOfChannel = 16;
  constexpr std::uint32_t kHalf = 1;
  std::uint64_t bytes = 0;
  for (std::size_t at = 0;;) {
    const std::size_t end = value.find('\0', at);
    if (end == std::string_view::npos) return std::nullopt;
    if (end == at) return end + 1 == value.size() ? std::optional(bytes) : std::nullopt;
    at = end + 1 + kOfChannel;
    if (at > value.size()) return std::nullopt;
    bytes += number_in(value, end + 1) == kHalf ? 2 : 4;
  }
}

// Width, height, and four bytes for each pixel.
bool is_preview(std::string_view value) {
  if (value.size() < 8) return false;
  const std::uint64_t width = number_in(value, 0), height = number_in(value, 4);
  const std::uint64_t pixels = (value.size() - 8) / 4;
  return width <= pixels && height <= pixels && width * height == pixels && value.size() % 4 == 0;
}

// Returns whether OpenEXR is going to read as much of the file as the attribute says that it has.
bool has_its_size(std::string_view type, std::string_view value) {
  if (type == "chlist") return bytes_of_channels(value).has_value();
  if (type == "preview") return is_preview(value);
  const auto fixed = std::find_if(kFixedSizes.begin(), kFixedSizes.end(),
                                  [&](const auto& candidate) { return candidate.first == type; });
  return fixed == kFixedSizes.end() || value.size() == fixed->second;
}

// Pixels of a side, both ends among them.
std::uint64_t side_between(std::uint32_t first, std::uint32_t last) {
  const std::int64_t side = std::int64_t{static_cast<std::int32_t>(last)} - static_cast<std::int32_t>(first) + 1;
  return static_cast<std::uint64_t>(std::max<std::int64_t>(side, 0));
}

// Takes an attribute that has its size.
void note_attribute(std::string_view name, std::string_view type, std::string_view value, ExrHeader& header) {
  if (name == "dataWindow" && type == "box2i") {
    header.width = std::max(header.width, side_between(number_in(value, 0), number_in(value, 8)));
    header.height = std::max(header.height, side_between(number_in(value, 4), number_in(value, 12)));
  } else if (type == "tiledesc") {
    header.columns = std::max<std::uint64_t>(header.columns, number_in(value, 0));
    header.rows = std::max<std::uint64_t>(header.rows, number_in(value, 4));
  } else if (type == "chlist") {
    header.pixel_bytes = std::max(header.pixel_bytes, *bytes_of_channels(value));
  }
}

}  // namespace

std::optional<ExrHeader> read_exr_header(std::istream& file, std::uint64_t file_bytes) {
  constexpr std::uint64_t kMostLines = 256;  // that any of its methods compresses together
  ExrHeader header{.rows = kMostLines};
  file.ignore(4);  // the signature
  std::array<std::uint8_t, 4> word{};
  if (!read_bytes(file, word)) return std::nullopt;
  const bool several = (u32_little_endian(word) & 0x1000) != 0;  // headers, of which an empty one is the last
  for (bool empty = true; file.peek() != std::istream::traits_type::eof();) {
    const bool header_ends = file.peek() == 0;
    if (!header_ends) {
      std::string name, type;
      std::getline(file, name, '\0');
      std::getline(file, type, '\0');
      if (!read_bytes(file, word)) return std::nullopt;
      const std::uint64_t size = u32_little_endian(word);
      if (size > file_bytes) return std::nullopt;
      std::string value(size, '\0');
      const bool is_there = static_cast<bool>(file.read(value.data(), static_cast<std::streamsize>(size)));
      if (!is_there || !has_its_size(type, value)) return std::nullopt;
      note_attribute(name, type, value, header);
      empty = false;
      continue;
    }
    if (!several || empty) return header;
    file.ignore(1);
    empty = true;
  }
  return std::nullopt;
}

bool png_is_complete(std::span<const std::uint8_t> bytes) {
  std::size_t at = 8;  // the signature
  while (at + kAroundData <= bytes.size()) {
    const std::size_t length = u32_big_endian(bytes.data() + at);
    if (length > bytes.size() - at - kAroundData) return false;
    if (std::memcmp(bytes.data() + at + 4, "IEND", 4) == 0) return true;
    at += kAroundData + length;
  }
  return false;
}

}  // namespace lumatlas
