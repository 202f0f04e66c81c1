// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/images/photograph.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <memory>
#include <optional>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "atlas/images/files/color_profile.h"
#include "atlas/images/files/embedded_profile.h"
#include "atlas/images/files/image_header.h"
#include "atlas/images/files/jpeg_file.h"
#include "atlas/images/files/picture_file.h"
#include "atlas/images/image_errors.h"
#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/whole_file.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;
using OIIO::TypeDesc;

// No format packs a photograph tighter than this: deflate ends at 1032 to 1, JPEG near 1000 to 1. A header that claims
// more is damaged, and is refused before anything is allocated for it. Small images may be as regular as they like.
constexpr std::uint64_t kMaxCompression = 2048;
constexpr std::uint64_t kAlwaysPlausible = 16 << 20;  // bytes

[[noreturn]] void fail(const fs::path& path, const std::string& reason) {
  throw InputError(path.string() + ": " + reason);
}

// The formats that people photograph and save in. OpenImageIO knows many more, whose readers are not fit for strangers'
// files: some crash on damaged ones.
enum class Format { jpeg, png, tiff, openexr, webp, heif, raw };

constexpr const char* kFormatsInWords = "JPEG, PNG, TIFF, WebP, OpenEXR, HEIC, AVIF or raw";

// The formats that OpenImageIO does not read here: see jpeg_file.h and picture_file.h.
bool has_own_decoder(Format format) {
  return format == Format::jpeg || format == Format::heif || format == Format::raw;
}

const char* name_of(Format format) {  // OpenImageIO's name for its reader, for formats that it reads
  switch (format) {
    case Format::png:
      return "png";
    case Format::tiff:
      return "tiff";
    case Format::openexr:
      return "openexr";
    default:
      return "webp";
  }
}

bool is_heif(std::string_view head) {
  constexpr std::array<std::string_view, 12> kBrands{"heic", "heix", "hevc", "hevx", "heim", "heis",
                                                     "hevm", "hevs", "mif1", "msf1", "avif", "avis"};
  return head.size() >= 12 && head.substr(4, 4) == "ftyp" &&
         std::find(kBrands.begin(), kBrands.end(), head.substr(8, 4)) != kBrands.end();
}

// Tells the format by the first bytes alone, because photographs are often misnamed.
constexpr std::size_t kSignatureBytes = 12;
std::optional<Format> format_of(std::string_view head) {
  using namespace std::string_view_literals;
  if (head.starts_with("\xff\xd8\xff")) return Format::jpeg;
  if (head.starts_with("\x89PNG\r\n\x1a\n")) return Format::png;
  if (head.starts_with("II*\0"sv) || head.starts_with("MM\0*"sv)) return Format::tiff;
  if (head.starts_with("II+\0"sv) || head.starts_with("MM\0+"sv)) return Format::tiff;  // BigTIFF
  if (head.starts_with("\x76\x2f\x31\x01")) return Format::openexr;
  if (head.starts_with("RIFF") && head.substr(std::min<std::size_t>(head.size(), 8)) == "WEBP") return Format::webp;
  if (is_heif(head)) return Format::heif;
  return std::nullopt;
}

// Names a file that is often met where a photograph should be, and says what to do about it. Empty for all other files.
std::string known_other(std::string_view head) {
  using namespace std::string_view_literals;
  if (head.starts_with("version http")) {
    return "is a pointer of Git LFS instead of the picture: fetch it with `git lfs pull`";
  }
  const bool jxl = head.starts_with("\xff\x0a") || head.starts_with("\0\0\0\x0cJXL "sv);
  if (jxl) return "is a JPEG XL image, which this program does not read: convert it to JPEG";
  const bool jp2 = head.starts_with("\xff\x4f\xff\x51") || head.starts_with("\0\0\0\x0cjP  "sv);
  if (jp2) return "is a JPEG 2000 image, which this program does not read: convert it to JPEG or TIFF";
  return {};
}

void require_readable(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) fail(path, "no such file");
  if (!fs::is_regular_file(status)) fail(path, "is not a file");
  // Not opened: files of the kernel say that they have no bytes, and reading some of them never ends.
  if (fs::file_size(path, error) == 0) fail(path, "is empty");
  if (!std::ifstream(path, std::ios::binary)) fail(path, "cannot be opened; check that it may be read");
}

// An image's file, on disk or in memory.
class Source {
 public:
  explicit Source(const fs::path& path) : path_(path) { require_readable(path); }
  Source(std::span<const std::uint8_t> file, const std::string& name) : path_(name), in_memory_(true), bytes_(file) {}

  [[nodiscard]] const fs::path& path() const { return path_; }  // in memory: what stands for it in sentences
  [[nodiscard]] bool in_memory() const { return in_memory_; }
  [[nodiscard]] std::uint64_t size() const { return in_memory() ? bytes_.size() : fs::file_size(path_); }
  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return bytes_; }  // in memory
  [[nodiscard]] std::unique_ptr<std::istream> stream() const {
    if (in_memory()) return std::make_unique<std::istringstream>(std::string(bytes_.begin(), bytes_.end()));
    return std::make_unique<std::ifstream>(path_, std::ios::binary);
  }
  // The reader of OpenImageIO, until the next call.
  [[nodiscard]] PatchedReader& reader() {
    using namespace OIIO::Filesystem;
    std::unique_ptr<IOProxy> file;
    if (in_memory_) {
      file = std::make_unique<IOMemReader>(bytes_.data(), bytes_.size());
    } else {
      file = std::make_unique<IOFile>(path_.string(), IOProxy::Read);
    }
    reader_.emplace(std::move(file));
    return *reader_;
  }

  // Reads the file into memory. If the file on disk is replaced afterwards, this source does not change.
  void hold() {
    if (in_memory()) return;
    held_ = read_whole_file(path_);
    bytes_ = std::span(reinterpret_cast<const std::uint8_t*>(held_.data()), held_.size());
    in_memory_ = true;
  }

 private:
  fs::path path_;
  bool in_memory_ = false;
  std::string held_;
  std::span<const std::uint8_t> bytes_;
  std::optional<PatchedReader> reader_;
};

Format format_of(const Source& source) {
  const std::unique_ptr<std::istream> file = source.stream();
  std::array<char, kSignatureBytes> head{};
  file->read(head.data(), head.size());
  const std::string_view bytes(head.data(), static_cast<std::size_t>(file->gcount()));
  if (bytes.empty()) fail(source.path(), "is empty");
  const std::optional<Format> format = is_raw(bytes, *file) ? Format::raw : format_of(bytes);
  if (!format && source.in_memory()) fail(source.path(), "not a PNG or JPEG image");
  if (const std::string other = known_other(bytes); !format && !other.empty()) fail(source.path(), other);
  if (!format) fail(source.path(), std::string("is no ") + kFormatsInWords + " image, by its first bytes");
  return *format;
}

using Reader = std::unique_ptr<OIIO::ImageInput>;

Reader reader_of(const Source& source, Format format) {
  Reader reader = OIIO::ImageInput::create(name_of(format));
  if (reader) return reader;
  (void)OIIO::geterror();  // an error that is not fetched would be printed at exit
  fail(source.path(), std::string("OpenImageIO is installed without a reader for ") + name_of(format));
}

// Others' readers would look for a file by the name that stands for the bytes.
bool may_be_in_memory(Format format) {
  return format == Format::jpeg || format == Format::png;
}

// The opened reader of a source, made when its input has been found sound. A JPEG has neither: see jpeg_file.h.
struct Opened {
  Format format;
  Reader reader;
  std::unique_ptr<PictureFile> file;  // for HEIC, AVIF and raw
  std::vector<std::uint8_t> profile;  // ICC, of a PNG, TIFF or WebP that is opened; empty: there is none
};

Opened reader_for(const Source& source) {
  const Format format = format_of(source);
  if (source.in_memory() && !may_be_in_memory(format)) fail(source.path(), "not a PNG or JPEG image");
  return {format, has_own_decoder(format) ? nullptr : reader_of(source, format), nullptr, {}};
}

// The values that must be known before anything is allocated for the pixels.
struct Header {
  std::uint64_t width, height;  // pixels, as stored
  std::uint64_t pixel_bytes;
  int orientation;  // EXIF: 1 as stored, 2..4 mirrored or turned by 180 degrees, 5..8 with rows and columns exchanged
};

bool is_plausible(const Source& source, std::uint64_t bytes) {
  return bytes <= kAlwaysPlausible + kMaxCompression * source.size();
}

void check_size(const Source& source, const Header& header) {
  const fs::path& path = source.path();
  const std::string size = size_text(header.width, header.height) + " pixels";
  if (header.width < 1 || header.height < 1) fail(path, size + ", there is nothing in it");
  if (header.width > kLongestImageSide || header.height > kLongestImageSide)
    fail(path, size + ", more than 65536 a side");
  if (!is_plausible(source, header.width * header.height * header.pixel_bytes)) {
    fail(path, "claims " + size + ", which its " + std::to_string(source.size()) + " bytes cannot hold");
  }
}

Header jpeg_header(const Source& source) {
  const std::optional<JpegHeader> jpeg = read_jpeg_header(*source.stream());
  if (!jpeg) fail(source.path(), "is damaged or cut off, a JPEG without a frame header");
  return {jpeg->width, jpeg->height, 3, jpeg->exif.orientation};
}

// Opens the file.
Header picture_header(const Source& source, Opened& image) {
  image.file = image.format == Format::heif ? open_heif(source.path()) : open_raw(source.path());
  const ImageExtent size = image.file->size();
  const std::uint64_t pixels = std::uint64_t{size.width} * size.height;
  return {size.width, size.height, pixels > 0 ? image.file->decoder_bytes() / pixels : 0, 1};
}

// OpenImageIO allocates all pixels while it opens a WebP file, so that its size must be known before.
Header webp_header(const Source& source) {
  const std::optional<ImageExtent> size = read_webp_size(*source.stream());
  if (!size) fail(source.path(), "is damaged or cut off, a WebP file without a sound header; copy it again");
  constexpr std::uint64_t kRgba = 4;  // channels that are allocated for every picture
  return {size->width, size->height, kRgba, 1};
}

// OpenEXR allocates a tile, or the lines that are compressed together, while it opens a file.
void check_exr(const Source& source) {
  const std::optional<ExrHeader> exr = read_exr_header(*source.stream(), source.size());
  if (!exr) fail(source.path(), "is damaged or cut off, an OpenEXR file without a sound header; copy it again");
  check_size(source, {exr->width, exr->height, exr->pixel_bytes, 1});
  if (exr->columns > kLongestImageSide || exr->rows > kLongestImageSide) {
    fail(source.path(), "its tiles have " + size_text(exr->columns, exr->rows) + " pixels, more than 65536 a side");
  }
  if (!is_plausible(source, std::max(exr->width, exr->columns) * exr->rows * exr->pixel_bytes)) {
    fail(source.path(), "claims " + std::to_string(exr->pixel_bytes) + " bytes a pixel in blocks of " +
                            std::to_string(exr->rows) + " lines, which its " + std::to_string(source.size()) +
                            " bytes cannot hold");
  }
}

// A reader that does its work on the calling thread, so that callers decide about parallelism.
void open_image(Source& source, Opened& image) {
  OIIO::ImageInput& reader = *image.reader;
  reader.threads(1);
  OIIO::ImageSpec config;
  if (image.format == Format::png || image.format == Format::tiff) {
    PatchedReader& file = source.reader();
    image.profile = image.format == Format::png ? hide_png_profile(file) : hide_tiff_profile(file);
    OIIO::Filesystem::IOProxy* proxy = &file;
    config.attribute("oiio:ioproxy", TypeDesc::PTR, &proxy);
  }
  if (image.format == Format::webp) image.profile = webp_profile(source.reader());
  config.attribute("oiio:UnassociatedAlpha", 1);  // alpha is dropped, so colours must not be multiplied by it
  OIIO::ImageSpec spec;
  if (!reader.open(source.path().string(), spec, config)) {
    fail(source.path(), std::string("cannot be read as ") + reader.format_name() + because(reader.geterror()));
  }
}

Header opened_header(const fs::path& path, const OIIO::ImageInput& reader) {
  const OIIO::ImageSpec& spec = reader.spec();
  if (spec.depth > 1) fail(path, "a volume, not a photograph");
  const int orientation = spec.get_int_attribute("Orientation", 1);
  return {static_cast<std::uint64_t>(std::max(0, spec.width)), static_cast<std::uint64_t>(std::max(0, spec.height)),
          spec.pixel_bytes(true), orientation >= 1 && orientation <= 8 ? orientation : 1};
}

Header own_header(const Source& source, Opened& image) {
  return image.format == Format::jpeg ? jpeg_header(source) : picture_header(source, image);
}

// Checks the header and opens the reader of the source. A JPEG has no reader: its decoder opens the file itself.
Header checked_header(Source& source, Opened& image, Orientation orientation) {
  if (image.format == Format::png && !png_header_is_sound(*source.stream())) {
    fail(source.path(), "is damaged or cut off, a PNG without a sound header; copy it again");
  }
  if (image.format == Format::openexr) check_exr(source);
  if (image.format == Format::webp) check_size(source, webp_header(source));
  if (image.reader) open_image(source, image);
  Header header = image.reader ? opened_header(source.path(), *image.reader) : own_header(source, image);
  check_size(source, header);
  if (orientation == Orientation::as_stored) header.orientation = 1;
  return header;
}

// Checks formats whose readers do not report an early end.
void check_complete(const Source& source, Format format) {
  const std::span<const std::uint8_t> bytes = source.bytes();
  if (!(format == Format::jpeg ? jpeg_is_complete(bytes) : png_is_complete(bytes))) {
    fail(source.path(), "the file is cut off after " + std::to_string(bytes.size()) + " bytes; copy it again");
  }
  if (format == Format::png && !png_pixels_are_sound(bytes)) {
    fail(source.path(), "is damaged, its pixels do not have their checksum; copy it again");
  }
}

ImageSize upright_size(const Header& header) {
  ImageSize size{static_cast<std::uint32_t>(header.width), static_cast<std::uint32_t>(header.height)};
  if (header.orientation >= 5) std::swap(size.width, size.height);
  return size;
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

// Returns the stored channels that are red, green and blue: by name, since an EXR may hold others; one or two channels
// are grey.
std::array<std::size_t, 3> rgb_channels(const OIIO::ImageSpec& spec) {
  if (spec.nchannels < 3) return {0, 0, 0};
  const std::array<int, 3> named{spec.channelindex("R"), spec.channelindex("G"), spec.channelindex("B")};
  if (named[0] < 0 || named[1] < 0 || named[2] < 0) return {0, 1, 2};
  return {static_cast<std::size_t>(named[0]), static_cast<std::size_t>(named[1]), static_cast<std::size_t>(named[2])};
}

// Rows in bands, so that damage ends the work where it is met: OpenImageIO 2.4 goes on to the last row, and ends the
// program once what it says of each of them is more than 16 MB.
template <typename Place>
void read_bands(const fs::path& path, OIIO::ImageInput& reader, const TypeDesc& type, const Place& place) {
  // A damaged row of a TIFF may be told of once for each row before it.
  const int rows = std::string_view(reader.format_name()) == "tiff" ? 1 : 256;
  const OIIO::ImageSpec& spec = reader.spec();
  const bool tiled = spec.tile_width > 0;
  const int band = tiled ? (rows + spec.tile_height - 1) / spec.tile_height * spec.tile_height : rows;
  const std::size_t row_bytes = static_cast<std::size_t>(spec.width) * spec.nchannels * type.size();
  // Asks for the file's own type if nothing is converted, because OpenImageIO converts by way of a buffer of 64 MB,
  // however small the photograph is.
  const TypeDesc wanted = spec.format == type && spec.channelformats.empty() ? TypeDesc(TypeDesc::UNKNOWN) : type;
  for (int row = 0; row < spec.height; row += std::min(band, spec.height - row)) {
    const int first = spec.y + row, last = first + std::min(band, spec.height - row);
    void* const to = place.before(static_cast<std::size_t>(row), row_bytes, static_cast<std::size_t>(last - first));
    const bool is_read = tiled ? reader.read_tiles(0, 0, spec.x, spec.x + spec.width, first, last, spec.z, spec.z + 1,
                                                   0, spec.nchannels, wanted, to)
                               : reader.read_scanlines(0, 0, first, last, spec.z, 0, spec.nchannels, wanted, to);
    if (!is_read) fail(path, "is damaged or cut off" + because(reader.geterror()));
    place.after(static_cast<std::size_t>(row));
  }
}

// All rows of an image.
struct WholeImage {
  std::uint8_t* pixels;
  [[nodiscard]] void* before(std::size_t row, std::size_t row_bytes, std::size_t) const {
    return pixels + row_bytes * row;
  }
  void after(std::size_t) const {}
};

void read_pixels(const fs::path& path, OIIO::ImageInput& reader, const TypeDesc& type, void* pixels) {
  read_bands(path, reader, type, WholeImage{static_cast<std::uint8_t*>(pixels)});
}

// One band after the other, each handed on.
struct EachBand {
  const PixelRows& use;
  std::vector<std::uint8_t>& band;
  [[nodiscard]] void* before(std::size_t, std::size_t row_bytes, std::size_t rows) const {
    band.resize(row_bytes * rows);
    return band.data();
  }
  void after(std::size_t row) const { use(static_cast<std::uint32_t>(row), band); }
};

// Reads the pixels as stored, as 8-bit sRGB.
template <typename Sample>
void read_as(const fs::path& path, OIIO::ImageInput& reader, const TypeDesc& type, std::vector<std::uint8_t>& rgb) {
  const OIIO::ImageSpec& spec = reader.spec();
  const auto samples_per_pixel = static_cast<std::size_t>(spec.nchannels);
  std::vector<Sample> stored(rgb.size() / 3 * samples_per_pixel);
  read_pixels(path, reader, type, stored.data());
  const std::array<std::size_t, 3> channels = rgb_channels(spec);
  std::uint8_t* out = rgb.data();
  for (std::size_t first = 0; first < stored.size(); first += samples_per_pixel) {
    for (const std::size_t channel : channels) *out++ = byte_of(stored[first + channel]);
  }
}

[[noreturn]] void fail_by_size(const fs::path& path, const Header& header, const std::string& found) {
  fail(path, "its header says " + size_text(header.width, header.height) + " pixels, its decoder finds " + found +
                 ": it is damaged");
}

// The buffers below are as large as the header says, and the decoder fills as many pixels as it has found.
void require_size_of(const fs::path& path, const Header& header, const OIIO::ImageSpec& spec) {
  const bool same = spec.width > 0 && spec.height > 0 && static_cast<std::uint64_t>(spec.width) == header.width &&
                    static_cast<std::uint64_t>(spec.height) == header.height && spec.depth <= 1 && spec.nchannels >= 1;
  if (!same) fail_by_size(path, header, size_text(spec.width, spec.height));
}

PicturePixels decoded_file(const fs::path& path, PictureFile& file, const Header& header) {
  PicturePixels pixels = file.decode();
  const auto [width, height] = pixels.size;
  if (width != header.width || height != header.height) fail_by_size(path, header, size_text(width, height));
  return pixels;
}

// Reads the pixels row by row as the file stores them, whatever its orientation, and converts them to sRGB.
std::vector<std::uint8_t> stored_rgb(const Source& source, Opened& image, const Header& header) {
  const fs::path& path = source.path();
  if (image.format == Format::jpeg) {
    JpegPixels pixels = decode_jpeg(source.bytes(), path, static_cast<std::uint32_t>(header.width),
                                    static_cast<std::uint32_t>(header.height));
    if (!pixels.profile.empty()) convert_to_srgb(pixels.profile, pixels.rgb);
    return std::move(pixels.rgb);
  }
  if (image.file) {
    PicturePixels pixels = decoded_file(path, *image.file, header);
    if (!pixels.profile.empty()) convert_to_srgb(pixels.profile, pixels.rgb);
    return std::move(pixels.rgb);
  }
  OIIO::ImageInput& reader = *image.reader;
  const OIIO::ImageSpec& spec = reader.spec();
  require_size_of(path, header, spec);
  std::vector<std::uint8_t> rgb(std::size_t{3} * header.width * header.height);
  if (spec.format.is_floating_point()) {
    read_as<float>(path, reader, TypeDesc::FLOAT, rgb);
  } else if (spec.format.size() > 1) {
    read_as<std::uint16_t>(path, reader, TypeDesc::UINT16, rgb);
  } else if (spec.nchannels == 3) {
    read_pixels(path, reader, TypeDesc::UINT8, rgb.data());  // no conversion
  } else {
    read_as<std::uint8_t>(path, reader, TypeDesc::UINT8, rgb);
  }
  if (!image.profile.empty() && !spec.format.is_floating_point()) convert_to_srgb(image.profile, rgb);
  return rgb;
}

// The stored pixel that is seen at the top left of the upright image, and the steps from it to the right and down, all
// in pixels of an image of `width` x `height` as stored. It is our own because ImageBufAlgo::reorient() of OpenImageIO
// 2.4 takes orientations 5 and 7 for each other.
struct UprightWalk {
  std::ptrdiff_t start, right, down;
};
UprightWalk walk_of(int orientation, std::ptrdiff_t width, std::ptrdiff_t height) {
  const std::ptrdiff_t last_column = width - 1, last_row = (height - 1) * width;
  const std::array<UprightWalk, 8> walks{{{0, 1, width},
                                          {last_column, -1, width},
                                          {last_row + last_column, -1, -width},
                                          {last_row, 1, -width},
                                          {0, width, 1},
                                          {last_row, -width, 1},
                                          {last_row + last_column, -width, -1},
                                          {last_column, width, -1}}};
  return walks.at(static_cast<std::size_t>(orientation - 1));
}

// `stored` has three values for each pixel of the header's size.
std::vector<std::uint8_t> upright_rgb(std::vector<std::uint8_t> stored, const Header& header) {
  if (header.orientation == 1) return stored;
  const ImageSize size = upright_size(header);
  const UprightWalk walk = walk_of(header.orientation, static_cast<std::ptrdiff_t>(header.width),
                                   static_cast<std::ptrdiff_t>(header.height));
  std::vector<std::uint8_t> rgb;
  rgb.reserve(stored.size());
  for (std::uint32_t y = 0; y < size.height; ++y) {
    std::ptrdiff_t pixel = walk.start + walk.down * y;
    for (std::uint32_t x = 0; x < size.width; ++x, pixel += walk.right) {
      const std::uint8_t* const from = &stored[static_cast<std::size_t>(3 * pixel)];
      rgb.insert(rgb.end(), from, from + 3);
    }
  }
  return rgb;
}

ImageSize size_of(Source& source, Orientation orientation) {
  Opened image = reader_for(source);
  return upright_size(checked_header(source, image, orientation));
}

// Returns the angle of three numbers, degrees, minutes and seconds; nothing where the header has none.
std::optional<double> gps_angle(const OIIO::ImageSpec& spec, const std::string& name, const char* negative) {
  const OIIO::ParamValue* const angle = spec.find_attribute(name);
  if (angle == nullptr || angle->type() != TypeDesc(TypeDesc::FLOAT, 3)) return std::nullopt;
  const double degrees = static_cast<double>(angle->get_float_indexed(0)) +
                         static_cast<double>(angle->get_float_indexed(1)) / 60 +
                         static_cast<double>(angle->get_float_indexed(2)) / 3600;
  return spec.get_string_attribute(name + "Ref") == negative ? -degrees : degrees;
}

std::optional<GpsPosition> gps_of(const OIIO::ImageSpec& spec) {
  const std::optional<double> latitude = gps_angle(spec, "GPS:Latitude", "S");
  const std::optional<double> longitude = gps_angle(spec, "GPS:Longitude", "W");
  if (!latitude || !longitude || !(std::abs(*latitude) <= 90) || !(std::abs(*longitude) <= 180)) return std::nullopt;
  const double altitude = static_cast<double>(spec.get_float_attribute("GPS:Altitude"));
  return GpsPosition{*latitude, *longitude, spec.get_int_attribute("GPS:AltitudeRef") == 1 ? -altitude : altitude};
}

CameraNote camera_note_of(Source& source) {
  Opened image = reader_for(source);
  const Header header = checked_header(source, image, Orientation::as_stored);
  CameraNote note{upright_size(header), {}, {}, 0, 0, {}};
  const auto take = [&](const ExifNote& exif) {
    note.make = exif.make;
    note.model = exif.model;
    note.focal_length_mm = exif.focal_length_mm;
    note.focal_length_35mm = exif.focal_length_35mm;
    note.gps = exif.gps;
  };
  if (image.reader) {
    const OIIO::ImageSpec& spec = image.reader->spec();
    take({1, std::string(spec.get_string_attribute("Make")), std::string(spec.get_string_attribute("Model")),
          static_cast<double>(spec.get_float_attribute("Exif:FocalLength")),
          static_cast<double>(spec.get_int_attribute("Exif:FocalLengthIn35mmFilm")), gps_of(spec)});
  } else if (image.file) {
    take(image.file->exif());
  } else if (const std::optional<JpegHeader> jpeg = read_jpeg_header(*source.stream())) {
    take(jpeg->exif);
  }
  return note;
}

// A file that has been found sound, and is open.
struct SoundImage {
  Opened image;
  Header header;
};

SoundImage open_sound(Source& source, Orientation orientation) {
  // A format that is read several times is held in memory, so that header, checks and decoder see one file; others are
  // opened once.
  if (may_be_in_memory(format_of(source))) source.hold();
  SoundImage sound{reader_for(source), {}};
  if (source.in_memory()) check_complete(source, sound.image.format);
  sound.header = checked_header(source, sound.image, orientation);
  return sound;
}

// Hands the pixels to `use` without holding all of them. False if they must be turned or converted.
bool stream_rows(const Source& source, Opened& image, const Header& header, const PixelRows& use) {
  if (header.orientation != 1) return false;
  if (image.format == Format::jpeg) {
    return decode_jpeg_rows(source.bytes(), source.path(), static_cast<std::uint32_t>(header.width),
                            static_cast<std::uint32_t>(header.height), use);
  }
  if (image.format != Format::png || !image.profile.empty()) return false;
  const OIIO::ImageSpec& spec = image.reader->spec();
  require_size_of(source.path(), header, spec);
  if (spec.nchannels != 3 || spec.format != TypeDesc::UINT8) return false;
  std::vector<std::uint8_t> band;
  read_bands(source.path(), *image.reader, TypeDesc::UINT8, EachBand{use, band});
  return true;
}

ImageSize read_rows_from(Source& source, const PixelRows& use) {
  auto [image, header] = open_sound(source, Orientation::exif);
  if (!stream_rows(source, image, header, use)) use(0, upright_rgb(stored_rgb(source, image, header), header));
  return upright_size(header);
}

Photograph read_from(Source& source, Orientation orientation) {
  auto [image, header] = open_sound(source, orientation);
  const ImageSize size = upright_size(header);
  Photograph photo;
  photo.width = size.width;
  photo.height = size.height;
  photo.rgb = upright_rgb(stored_rgb(source, image, header), header);
  return photo;
}

// Throws InputError for a file that holds no 16-bit numbers, but a picture to look at.
void require_grey_16(const fs::path& path, const Opened& image) {
  const std::string otherwise = ", must have one of 16 bits: numbers are kept in a grey PNG of 16 bits";
  if (!image.reader) {
    const char* const kind = image.format == Format::jpeg ? "JPEG" : "photograph";
    fail(path, std::string("is a ") + kind + ", whose channels have 8 bits" + otherwise);
  }
  const OIIO::ImageSpec& spec = image.reader->spec();
  if (spec.nchannels == 1 && spec.format == TypeDesc::UINT16) return;
  fail(path, "has " + std::to_string(spec.nchannels) + (spec.nchannels == 1 ? " channel of " : " channels of ") +
                 std::to_string(8 * spec.format.size()) + " bits" + otherwise);
}

GreyImage grey_from(Source& source) {
  if (may_be_in_memory(format_of(source))) source.hold();
  Opened image = reader_for(source);
  if (source.in_memory()) check_complete(source, image.format);
  const Header header = checked_header(source, image, Orientation::as_stored);
  require_grey_16(source.path(), image);
  require_size_of(source.path(), header, image.reader->spec());
  GreyImage grey{static_cast<std::uint32_t>(header.width), static_cast<std::uint32_t>(header.height), {}};
  grey.values.resize(std::size_t{grey.width} * grey.height);
  read_pixels(source.path(), *image.reader, TypeDesc::UINT16, grey.values.data());
  return grey;
}

std::vector<std::uint8_t> threefold(const std::vector<std::uint8_t>& values) {
  std::vector<std::uint8_t> result;
  result.reserve(3 * values.size());
  for (const std::uint8_t value : values) result.insert(result.end(), 3, value);
  return result;
}

// Reads the alpha as three equal values a pixel, upright.
std::vector<std::uint8_t> alpha_from(Source& source, Orientation orientation) {
  Opened image = reader_for(source);
  if (image.format == Format::jpeg) return {};
  const Header header = checked_header(source, image, orientation);
  if (image.file) {
    if (image.format == Format::raw) return {};
    return threefold(decoded_file(source.path(), *image.file, header).alpha);
  }
  const int channel = image.reader->spec().alpha_channel;
  if (channel < 0) return {};
  require_size_of(source.path(), header, image.reader->spec());
  std::vector<std::uint8_t> stored(std::size_t{header.width} * header.height);
  if (!image.reader->read_image(0, 0, channel, channel + 1, TypeDesc::UINT8, stored.data())) {
    fail(source.path(), "is damaged or cut off" + because(image.reader->geterror()));
  }
  return upright_rgb(threefold(stored), header);
}

}  // namespace

ImageSize photograph_size(const fs::path& path, Orientation orientation) {
  Source source(path);
  return size_of(source, orientation);
}

ImageSize photograph_size(std::span<const std::uint8_t> file, const std::string& name) {
  Source source(file, name);
  return size_of(source, Orientation::exif);
}

CameraNote read_camera_note(const fs::path& path) {
  Source source(path);
  return camera_note_of(source);
}

Photograph read_photograph(const fs::path& path, Orientation orientation) {
  Source source(path);
  return read_from(source, orientation);
}

std::vector<std::uint8_t> read_alpha(const fs::path& path, Orientation orientation) {
  Source source(path);
  const std::vector<std::uint8_t> values = alpha_from(source, orientation);
  std::vector<std::uint8_t> alpha(values.size() / 3);
  for (std::size_t i = 0; i < alpha.size(); ++i) alpha[i] = values[3 * i];
  return alpha;
}

GreyImage read_grey_image(const fs::path& path) {
  Source source(path);
  return grey_from(source);
}

Photograph read_photograph(std::span<const std::uint8_t> file, const std::string& name) {
  Source source(file, name);
  return read_from(source, Orientation::exif);
}

ImageSize read_photograph_rows(const fs::path& path, const PixelRows& use) {
  Source source(path);
  return read_rows_from(source, use);
}

ImageSize read_photograph_rows(std::span<const std::uint8_t> file, const std::string& name, const PixelRows& use) {
  Source source(file, name);
  return read_rows_from(source, use);
}

}  // namespace lumatlas
