// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/photograph.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "mesh/errors.h"
#include "mesh/pending_file.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;
using OIIO::TypeDesc;

constexpr int kMaxSide = 65536;  // pixels; also the largest camera

// No format packs a photograph tighter than this: deflate ends at 1032 to 1, JPEG near 1000 to 1. A header that claims
// more is damaged, and is refused before anything is allocated for it. Small images may be as regular as they like.
constexpr std::uint64_t kMaxCompression = 2048;
constexpr std::uint64_t kAlwaysPlausible = 16 << 20;  // bytes

[[noreturn]] void fail(const fs::path& path, const std::string& reason) {
  throw InputError(path.string() + ": " + reason);
}

// OpenImageIO's messages can span lines; an InputError is one sentence.
std::string one_line(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.empty() ? "no reason given" : text;
}

struct Signature {
  std::string_view first_bytes;
  const char* format;  // as OpenImageIO names it
};
constexpr std::array<Signature, 9> kSignatures{{
    {"\xff\xd8\xff", "jpeg"},
    {"\x89PNG\r\n\x1a\n", "png"},
    {{"II*\0", 4}, "tiff"},
    {{"MM\0*", 4}, "tiff"},
    {"\x76\x2f\x31\x01", "openexr"},
    {"#?", "hdr"},
    {"BM", "bmp"},
    {"GIF8", "gif"},
    {"RIFF", "webp"},
}};

// By the first bytes, because photographs are often misnamed; else by the ending.
std::string format_of(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) fail(path, "no such file");
  if (!fs::is_regular_file(status)) fail(path, "is not a file");
  std::array<char, 8> head{};
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(path, "cannot be opened; check that it may be read");
  file.read(head.data(), head.size());
  const std::string_view bytes(head.data(), static_cast<std::size_t>(file.gcount()));
  for (const Signature& signature : kSignatures) {
    if (bytes.starts_with(signature.first_bytes)) return signature.format;
  }
  const std::string ending = path.extension().string();
  return ending.empty() ? ending : ending.substr(1);
}

// A reader that does its work on the calling thread, so that callers decide about parallelism.
std::unique_ptr<OIIO::ImageInput> open_image(const fs::path& path) {
  const std::string format = format_of(path);
  std::unique_ptr<OIIO::ImageInput> input;
  if (!format.empty()) input = OIIO::ImageInput::create(format);
  if (!input) {
    OIIO::geterror();  // an error nobody fetched would be printed at exit
    fail(path, "not an image: neither its first bytes nor its ending name a known format");
  }
  input->threads(1);
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);  // alpha is dropped, so colours must not be multiplied by it
  OIIO::ImageSpec spec;
  if (!input->open(path.string(), spec, config)) {
    fail(path, "cannot be read as " + format + " (" + one_line(input->geterror()) + ")");
  }
  return input;
}

void check_size(const fs::path& path, const OIIO::ImageSpec& spec) {
  const std::string size = std::to_string(spec.width) + "x" + std::to_string(spec.height) + " pixels";
  if (spec.width < 1 || spec.height < 1) fail(path, size + ", there is nothing in it");
  if (spec.width > kMaxSide || spec.height > kMaxSide) fail(path, size + ", more than 65536 a side");
  if (spec.depth > 1) fail(path, "a volume, not a photograph");
  const std::uint64_t file_bytes = fs::file_size(path);
  if (spec.image_bytes(true) > kAlwaysPlausible + kMaxCompression * file_bytes) {
    fail(path, "claims " + size + ", which its " + std::to_string(file_bytes) + " bytes cannot hold");
  }
}

// EXIF 2.32, tag 0x0112: 1 as stored, 2..4 mirrored or turned by 180 degrees, 5..8 with rows and columns exchanged.
int orientation_of(const OIIO::ImageSpec& spec) {
  const int orientation = spec.get_int_attribute("Orientation", 1);
  return orientation >= 1 && orientation <= 8 ? orientation : 1;
}

bool exchanges_sides(int orientation) {
  return orientation >= 5;
}

ImageSize oriented_size(const OIIO::ImageSpec& spec) {
  ImageSize size{static_cast<std::uint32_t>(spec.width), static_cast<std::uint32_t>(spec.height)};
  if (exchanges_sides(orientation_of(spec))) std::swap(size.width, size.height);
  return size;
}

// The stored pixel that is seen at the top left of the upright image, and the steps from it to the right and down.
struct Walk {
  std::ptrdiff_t start, right, down;  // pixels
};
Walk walk_of(int orientation, std::ptrdiff_t width, std::ptrdiff_t height) {
  const std::ptrdiff_t last_column = width - 1;
  const std::ptrdiff_t last_row = (height - 1) * width;
  switch (orientation) {
    case 2:
      return {last_column, -1, width};
    case 3:
      return {last_row + last_column, -1, -width};
    case 4:
      return {last_row, 1, -width};
    case 5:
      return {0, width, 1};
    case 6:
      return {last_row, -width, 1};
    case 7:
      return {last_row + last_column, -width, -1};
    case 8:
      return {last_column, width, -1};
    default:
      return {0, 1, width};
  }
}

std::uint8_t byte_of(std::uint8_t value) {
  return value;
}
std::uint8_t byte_of(std::uint16_t value) {
  return static_cast<std::uint8_t>((value + 128u) / 257u);
}

// IEC 61966-2-1. Written so that NaN becomes black.
std::uint8_t byte_of(float linear) {
  if (!(linear > 0.0f)) return 0;
  if (linear >= 1.0f) return 255;
  const float encoded = linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(encoded * 255.0f + 0.5f);
}

float linear_of(std::uint8_t byte) {
  const float encoded = static_cast<float>(byte) / 255.0f;
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

// Which stored channels are red, green and blue: by name, since an EXR may hold others; one or two channels are grey.
std::array<std::size_t, 3> rgb_channels(const OIIO::ImageSpec& spec) {
  if (spec.nchannels < 3) return {0, 0, 0};
  const std::array<int, 3> named{spec.channelindex("R"), spec.channelindex("G"), spec.channelindex("B")};
  if (named[0] < 0 || named[1] < 0 || named[2] < 0) return {0, 1, 2};
  return {static_cast<std::size_t>(named[0]), static_cast<std::size_t>(named[1]), static_cast<std::size_t>(named[2])};
}

template <typename Sample>
void copy_upright(std::span<const Sample> stored, const OIIO::ImageSpec& spec, Photograph& photo) {
  const std::array<std::size_t, 3> channels = rgb_channels(spec);
  const Walk walk = walk_of(orientation_of(spec), spec.width, spec.height);
  std::uint8_t* out = photo.rgb.data();
  for (std::uint32_t y = 0; y < photo.height; ++y) {
    std::ptrdiff_t pixel = walk.start + walk.down * y;
    for (std::uint32_t x = 0; x < photo.width; ++x, pixel += walk.right) {
      const Sample* const samples = stored.data() + pixel * spec.nchannels;
      for (const std::size_t channel : channels) *out++ = byte_of(samples[channel]);
    }
  }
}

void read_pixels(const fs::path& path, OIIO::ImageInput& input, TypeDesc type, void* pixels) {
  if (!input.read_image(0, 0, 0, -1, type, pixels)) {
    fail(path, "is damaged or cut off (" + one_line(input.geterror()) + ")");
  }
}

template <typename Sample>
void read_as(const fs::path& path, OIIO::ImageInput& input, TypeDesc type, Photograph& photo) {
  const OIIO::ImageSpec spec = input.spec();
  std::vector<Sample> stored(spec.image_pixels() * static_cast<std::uint64_t>(spec.nchannels));
  read_pixels(path, input, type, stored.data());
  copy_upright<Sample>(stored, spec, photo);
}

void read_into(const fs::path& path, OIIO::ImageInput& input, Photograph& photo) {
  const OIIO::ImageSpec& spec = input.spec();
  if (spec.format.is_floating_point()) {
    read_as<float>(path, input, TypeDesc::FLOAT, photo);
  } else if (spec.format.size() > 1) {
    read_as<std::uint16_t>(path, input, TypeDesc::UINT16, photo);
  } else if (spec.nchannels == 3 && orientation_of(spec) == 1) {
    read_pixels(path, input, TypeDesc::UINT8, photo.rgb.data());  // as it is
  } else {
    read_as<std::uint8_t>(path, input, TypeDesc::UINT8, photo);
  }
}

void check(const Photograph& image) {
  const std::size_t expected = std::size_t{3} * image.width * image.height;
  if (expected == 0 || image.width > kMaxSide || image.height > kMaxSide) {
    throw std::invalid_argument("image size is " + std::to_string(image.width) + "x" + std::to_string(image.height) +
                                "; each side must be in [1, 65536]");
  }
  if (image.rgb.size() != expected) {
    throw std::invalid_argument("image.rgb has " + std::to_string(image.rgb.size()) + " bytes; it must have " +
                                std::to_string(expected) + " (3 * width * height)");
  }
}

// Formats that hold numbers instead of codes get linear light, as read_photograph() expects of them.
bool write_pixels(OIIO::ImageOutput& output, const Photograph& image) {
  if (!output.spec().format.is_floating_point()) return output.write_image(TypeDesc::UINT8, image.rgb.data());
  std::vector<float> linear(image.rgb.size());
  std::transform(image.rgb.begin(), image.rgb.end(), linear.begin(), linear_of);
  return output.write_image(TypeDesc::FLOAT, linear.data());
}

}  // namespace

ImageSize photograph_size(const fs::path& path) {
  const auto input = open_image(path);
  check_size(path, input->spec());
  return oriented_size(input->spec());
}

Photograph read_photograph(const fs::path& path) {
  const auto input = open_image(path);
  check_size(path, input->spec());
  const ImageSize size = oriented_size(input->spec());
  Photograph photo;
  photo.width = size.width;
  photo.height = size.height;
  photo.rgb.resize(std::size_t{3} * size.width * size.height);
  read_into(path, *input, photo);
  return photo;
}

void write_image(const fs::path& path, const Photograph& image) {
  check(image);
  const auto output = OIIO::ImageOutput::create(path.string());
  if (!output) {
    OIIO::geterror();
    fail(path, "no image format is known by the ending '" + path.extension().string() + "'; use .png or .jpg");
  }
  output->threads(1);
  OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height), 3, TypeDesc::UINT8);
  spec.attribute("png:compressionLevel", 1);  // fast; the defaults take several times as long
  PendingFile file(path);
  if (!output->open(file.path().string(), spec) || !write_pixels(*output, image) || !output->close()) {
    fail(path, "cannot be written (" + one_line(output->geterror()) + ")");
  }
  file.commit();
}

}  // namespace lumatlas
