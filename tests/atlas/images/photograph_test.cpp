// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/images/photograph.h"

#include <OpenImageIO/imageio.h>

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/whole_file.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using OIIO::TypeDesc;

// Samples as they are, through OpenImageIO and not through the code under test.
void write_stored(const fs::path& path, const OIIO::ImageSpec& spec, TypeDesc type, const void* samples) {
  const auto output = OIIO::ImageOutput::create(path.string());
  REQUIRE(output);
  REQUIRE(output->open(path.string(), spec));
  REQUIRE(output->write_image(type, samples));
  REQUIRE(output->close());
}

// One row of samples of one channel or more.
template <typename Sample>
Photograph through_file(const fs::path& path, TypeDesc type, int channels, const std::vector<Sample>& samples) {
  const OIIO::ImageSpec spec(static_cast<int>(samples.size()) / channels, 1, channels, type);
  write_stored(path, spec, type, samples.data());
  return read_photograph(path);
}

// Red says the column, green the row, blue the block's parity; a block is `block` pixels wide.
Photograph position_pattern(std::uint32_t width, std::uint32_t height, std::uint32_t block = 1) {
  Photograph image{width, height, {}, {}};
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      const std::uint32_t column = x / block, row = y / block;
      image.rgb.push_back(static_cast<std::uint8_t>(20 + 30 * column));
      image.rgb.push_back(static_cast<std::uint8_t>(20 + 30 * row));
      image.rgb.push_back((column + row) % 2 ? 200 : 40);
    }
  }
  return image;
}

std::array<int, 3> pixel(const Photograph& image, std::uint32_t x, std::uint32_t y) {
  const std::size_t at = 3 * (std::size_t{y} * image.width + x);
  return {image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
}

void write_oriented(const fs::path& path, const Photograph& stored, int orientation) {
  OIIO::ImageSpec spec(static_cast<int>(stored.width), static_cast<int>(stored.height), 3, TypeDesc::UINT8);
  spec.attribute("Orientation", orientation);
  spec.attribute("CompressionQuality", 100);
  write_stored(path, spec, TypeDesc::UINT8, stored.rgb.data());
}

// EXIF 2.32, table for tag 0x0112: which visual side the stored row 0 and the stored column 0 are.
enum class Side { Top, Right, Bottom, Left };
struct Sides {
  Side row_0, column_0;
};
const std::array<Sides, 8> kSides{{{Side::Top, Side::Left},
                                   {Side::Top, Side::Right},
                                   {Side::Bottom, Side::Right},
                                   {Side::Bottom, Side::Left},
                                   {Side::Left, Side::Top},
                                   {Side::Right, Side::Top},
                                   {Side::Right, Side::Bottom},
                                   {Side::Left, Side::Bottom}}};

// Returns the position of a pixel that lies `distance` away from `side`, in an upright image of width or height
// `extent`.
std::uint32_t from_side(Side side, std::uint32_t distance, std::uint32_t extent) {
  return side == Side::Right || side == Side::Bottom ? extent - 1 - distance : distance;
}

std::pair<std::uint32_t, std::uint32_t> upright_place(const Sides& sides, const Photograph& upright,
                                                      std::uint32_t column, std::uint32_t row) {
  if (sides.row_0 == Side::Top || sides.row_0 == Side::Bottom) {
    return {from_side(sides.column_0, column, upright.width), from_side(sides.row_0, row, upright.height)};
  }
  return {from_side(sides.row_0, row, upright.width), from_side(sides.column_0, column, upright.height)};
}

void check_upright(const fs::path& path, const Photograph& stored, int orientation, std::uint32_t step, int tolerance) {
  const Photograph upright = read_photograph(path);
  const bool exchanged = orientation >= 5;
  REQUIRE(upright.width == (exchanged ? stored.height : stored.width));
  REQUIRE(upright.height == (exchanged ? stored.width : stored.height));
  const ImageSize size = photograph_size(path);
  CHECK(size.width == upright.width);
  CHECK(size.height == upright.height);
  for (std::uint32_t row = step / 2; row < stored.height; row += step) {
    for (std::uint32_t column = step / 2; column < stored.width; column += step) {
      const auto [x, y] = upright_place(kSides[static_cast<std::size_t>(orientation - 1)], upright, column, row);
      const std::array<int, 3> expected = pixel(stored, column, row), found = pixel(upright, x, y);
      for (std::size_t channel = 0; channel < 3; ++channel) {
        CHECK(std::abs(found[channel] - expected[channel]) <= tolerance);
      }
    }
  }
}

TEST_CASE("a photograph is upright after each of the eight EXIF orientations") {
  const TemporaryFolder folder;
  const int orientation = GENERATE(1, 2, 3, 4, 5, 6, 7, 8);
  CAPTURE(orientation);
  SECTION("TIFF, exactly") {
    const Photograph stored = position_pattern(7, 4);
    write_oriented(folder / "a.tif", stored, orientation);
    check_upright(folder / "a.tif", stored, orientation, 1, 0);
    CHECK(read_photograph(folder / "a.tif", Orientation::as_stored).rgb == stored.rgb);
    CHECK(photograph_size(folder / "a.tif", Orientation::as_stored).width == stored.width);
  }
  SECTION("JPEG, blocks of 16 pixels, so that subsampled colour is flat at their centres") {
    const Photograph stored = position_pattern(7 * 16, 4 * 16, 16);
    write_oriented(folder / "a.jpg", stored, orientation);
    check_upright(folder / "a.jpg", stored, orientation, 16, 4);  // quantisation of 8-bit YCbCr, at quality 100
    CHECK(photograph_size(folder / "a.jpg", Orientation::as_stored).width == stored.width);
  }
}

TEST_CASE("an orientation outside of 1 to 8 is taken for upright") {
  const TemporaryFolder folder;
  const Photograph stored = position_pattern(48, 32, 16);
  write_oriented(folder / "a.jpg", stored, 6);
  std::string bytes = bytes_of(folder / "a.jpg");
  const std::size_t entry = bytes.find(std::string("\x12\x01\x03\x00\x01\x00\x00\x00\x06", 9));
  REQUIRE(entry != std::string::npos);
  bytes[entry + 8] = 9;
  CHECK(read_photograph(folder.with_file("b.jpg", bytes)).width == 48);
  bytes[entry + 8] = 8;
  CHECK(read_photograph(folder.with_file("b.jpg", bytes)).width == 32);
}

TEST_CASE("EXIF in big-endian order turns a photograph too") {
  const TemporaryFolder folder;
  write_image(folder / "a.jpg", position_pattern(48, 32, 16));
  std::string bytes = bytes_of(folder / "a.jpg");
  const std::string exif(
      "\xff\xe1\0\x22"
      "Exif\0\0"
      "MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x08\0\0\0\0\0\0",
      36);
  const ImageSize size = photograph_size(folder.with_file("b.jpg", bytes.substr(0, 2) + exif + bytes.substr(2)));
  CHECK(size.width == 32);
  CHECK(size.height == 48);
  CHECK(read_photograph(folder / "b.jpg").width == 32);
}

TEST_CASE("a header's words about the camera are read, and nothing where it has none") {
  const TemporaryFolder folder;
  for (const char* const name : {"a.jpg", "a.tif"}) {
    CAPTURE(name);
    OIIO::ImageSpec spec(4, 2, 3, TypeDesc::UINT8);
    const std::vector<std::uint8_t> samples(24, 100);
    write_stored(folder / name, spec, TypeDesc::UINT8, samples.data());
    const CameraNote none = read_camera_note(folder / name);
    CHECK(none.make.empty());
    CHECK(none.model.empty());
    CHECK(none.focal_length_mm == 0);
    spec.attribute("Make", "A maker");
    spec.attribute("Model", "M1");  // so short that EXIF keeps it in the entry
    spec.attribute("Exif:FocalLength", 4.25f);
    spec.attribute("Orientation", 6);  // turned
    write_stored(folder / name, spec, TypeDesc::UINT8, samples.data());
    const CameraNote note = read_camera_note(folder / name);
    CHECK(note.size.width == 4);
    CHECK(note.size.height == 2);
    CHECK(note.make == "A maker");
    CHECK(note.model == "M1");
    CHECK(note.focal_length_mm == Approx(4.25));
    CHECK(note.focal_length_35mm == 0);
    CHECK_FALSE(note.gps);
  }
}

TEST_CASE("a JPEG that is written with a note of camera and place says them") {
  const TemporaryFolder folder;
  const Photograph photograph{4, 2, std::vector<std::uint8_t>(24, 100), {}};
  for (const GpsPosition& place :
       {GpsPosition{-33.8567844, 151.2152967, 12.5}, GpsPosition{52.5162746, -13.377704, -3}}) {
    const CameraNote note{{4, 2}, "A maker", "M1", 4.25, 26, place};
    const std::vector<std::uint8_t> bytes = encode_image(photograph, {ImageFormat::jpeg, 95}, note);
    write_whole_file(folder / "a.jpg", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    const CameraNote read = read_camera_note(folder / "a.jpg");
    CHECK(read.make == "A maker");
    CHECK(read.model == "M1");
    CHECK(read.focal_length_mm == Approx(4.25));
    CHECK(read.focal_length_35mm == 26);
    REQUIRE(read.gps);
    constexpr double kTenCentimetres = 1e-6;  // degrees
    CHECK(read.gps->latitude_deg == Approx(place.latitude_deg).margin(kTenCentimetres));
    CHECK(read.gps->longitude_deg == Approx(place.longitude_deg).margin(kTenCentimetres));
    CHECK(read.gps->altitude_m == Approx(place.altitude_m));
    CHECK(read_photograph(folder / "a.jpg").rgb.size() == photograph.rgb.size());
  }
}

TEST_CASE("16-bit samples are rounded to the nearest of 256 steps") {
  const TemporaryFolder folder;
  std::vector<std::uint16_t> samples;
  for (std::uint32_t value = 0; value < 65535; value += 51) samples.push_back(static_cast<std::uint16_t>(value));
  samples.insert(samples.end(), {128, 129, 65406, 65407, 65535});  // around the first and the last step
  const std::string name = GENERATE("a.png", "a.tif");
  const Photograph photo = through_file(folder / name, TypeDesc::UINT16, 1, samples);
  REQUIRE(photo.width == samples.size());
  for (std::uint32_t x = 0; x < photo.width; ++x) {
    CHECK(std::abs(pixel(photo, x, 0)[0] - samples[x] / 257.0) <= 0.5);
  }
}

TEST_CASE("a grey photograph has three equal channels") {
  const TemporaryFolder folder;
  const Photograph photo = through_file<std::uint8_t>(folder / "a.png", TypeDesc::UINT8, 1, {0, 7, 255});
  CHECK(photo.rgb == std::vector<std::uint8_t>{0, 0, 0, 7, 7, 7, 255, 255, 255});
}

TEST_CASE("alpha is dropped and colours under it are as stored") {
  const TemporaryFolder folder;
  OIIO::ImageSpec spec(2, 1, 4, TypeDesc::UINT8);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  const std::array<std::uint8_t, 8> rgba{200, 100, 50, 128, 10, 20, 30, 0};
  write_stored(folder / "a.png", spec, TypeDesc::UINT8, rgba.data());
  CHECK(read_photograph(folder / "a.png").rgb == std::vector<std::uint8_t>{200, 100, 50, 10, 20, 30});
  const std::array<std::uint8_t, 4> grey_alpha{90, 128, 60, 0};
  spec = OIIO::ImageSpec(2, 1, 2, TypeDesc::UINT8);
  spec.alpha_channel = 1;
  spec.attribute("oiio:UnassociatedAlpha", 1);
  write_stored(folder / "b.png", spec, TypeDesc::UINT8, grey_alpha.data());
  CHECK(read_photograph(folder / "b.png").rgb == std::vector<std::uint8_t>{90, 90, 90, 60, 60, 60});
}

TEST_CASE("alpha is read by itself, turned as the photograph is, and empty where there is none") {
  const TemporaryFolder folder;
  OIIO::ImageSpec spec(2, 1, 4, TypeDesc::UINT8);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  const std::array<std::uint8_t, 8> rgba{200, 100, 50, 128, 10, 20, 30, 0};
  write_stored(folder / "a.png", spec, TypeDesc::UINT8, rgba.data());
  CHECK(read_alpha(folder / "a.png") == std::vector<std::uint8_t>{128, 0});
  spec.attribute("Orientation", 3);  // turned by 180 degrees
  spec.channelnames = {"R", "G", "B", "A"};
  spec.alpha_channel = 3;
  write_stored(folder / "turned.tif", spec, TypeDesc::UINT8, rgba.data());
  CHECK(read_alpha(folder / "turned.tif", Orientation::exif) == std::vector<std::uint8_t>{0, 128});
  CHECK(read_alpha(folder / "turned.tif", Orientation::as_stored) == std::vector<std::uint8_t>{128, 0});
  write_image(folder / "b.png", {2, 1, {1, 2, 3, 4, 5, 6}, {}});
  write_image(folder / "c.jpg", {2, 1, {1, 2, 3, 4, 5, 6}, {}});
  CHECK(read_alpha(folder / "b.png").empty());
  CHECK(read_alpha(folder / "c.jpg").empty());
  CHECK_THROWS_AS(read_alpha(folder / "none.png"), InputError);
}

TEST_CASE("floating-point samples are linear light") {
  const TemporaryFolder folder;
  // IEC 61966-2-1 by hand: 0.18 -> 0.46136 -> 117.6; 0.5 -> 0.73536 -> 187.5; 0.002 -> 0.02584 -> 6.6
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const Photograph photo =
      through_file<float>(folder / "a.exr", TypeDesc::FLOAT, 3, {0, 0.002f, 0.18f, 0.5f, 1, 7, -1, nan, inf});
  CHECK(photo.rgb == std::vector<std::uint8_t>{0, 7, 118, 188, 255, 255, 0, 0, 255});
}

TEST_CASE("an EXR's colours are found by name among other channels") {
  const TemporaryFolder folder;
  OIIO::ImageSpec spec(1, 1, 5, TypeDesc::FLOAT);
  spec.channelnames = {"B", "G", "R", "A", "Z"};
  const std::array<float, 5> samples{0.0f, 1.0f, 0.18f, 1.0f, 5.0f};
  write_stored(folder / "a.exr", spec, TypeDesc::FLOAT, samples.data());
  CHECK(read_photograph(folder / "a.exr").rgb == std::vector<std::uint8_t>{118, 255, 0});
}

TEST_CASE("what was written without loss reads back the same") {
  const TemporaryFolder folder;
  Photograph image{16, 16, {}, {}};
  for (int value = 0; value < 256; ++value) {
    const auto byte = static_cast<std::uint8_t>(value);
    image.rgb.insert(image.rgb.end(),
                     {byte, static_cast<std::uint8_t>(255 - value), static_cast<std::uint8_t>(7 * value)});
  }
  const std::string name = GENERATE("a.png", "a.PNG", "a.tif", "a.exr");
  write_image(folder / name, image);
  const Photograph again = read_photograph(folder / name);
  CHECK(again.width == 16);
  CHECK(again.rgb == image.rgb);
  CHECK(again.valid.empty());
}

TEST_CASE("a photograph with another format's ending is read by its first bytes") {
  const TemporaryFolder folder;
  const Photograph image = position_pattern(5, 3);
  write_image(folder / "a.png", image);
  fs::rename(folder / "a.png", folder / "a.jpg");
  CHECK(read_photograph(folder / "a.jpg").rgb == image.rgb);
  fs::rename(folder / "a.jpg", folder / "without-ending");
  CHECK(photograph_size(folder / "without-ending").width == 5);
}

TEST_CASE("a file that is cut off is refused at any length") {
  const TemporaryFolder folder;
  const std::string name = GENERATE("a.jpg", "a.png", "a.tif");
  write_image(folder / name, position_pattern(60, 40, 8));
  const std::string bytes = bytes_of(folder / name);
  for (std::size_t length = 1; length < bytes.size(); length += length < 700 ? 1 : 97) {
    CAPTURE(name, length);
    const fs::path cut = folder.with_file("cut-" + name, bytes.substr(0, length));
    CHECK_THROWS_AS(read_photograph(cut), InputError);
  }
}

TEST_CASE("a progressive JPEG that is cut off is refused") {
  const TemporaryFolder folder;
  OIIO::ImageSpec spec(64, 48, 3, TypeDesc::UINT8);
  spec.attribute("jpeg:progressive", 1);
  write_stored(folder / "a.jpg", spec, TypeDesc::UINT8, position_pattern(64, 48, 8).rgb.data());
  const std::string bytes = bytes_of(folder / "a.jpg");
  CHECK(read_photograph(folder.with_file("padded.jpg", bytes + std::string(100, '\0'))).width == 64);
  const fs::path cut = folder.with_file("cut.jpg", bytes.substr(0, bytes.size() - 2));
  CHECK_THROWS_WITH(read_photograph(cut), cut.string() + ": the file is cut off after " +
                                              std::to_string(bytes.size() - 2) + " bytes; copy it again");
}

TEST_CASE("a file that is no photograph gets a sentence that says so") {
  const TemporaryFolder folder;
  const auto check_both = [](const fs::path& path, const std::string& reason) {
    CHECK_THROWS_WITH(photograph_size(path), path.string() + ": " + reason);
    CHECK_THROWS_WITH(read_photograph(path), path.string() + ": " + reason);
  };
  check_both(folder / "missing.jpg", "no such file");
  check_both(folder.path(), "is not a file");
  check_both(folder.with_file("empty.png", ""), "is empty");
  const std::string no_image = "is no JPEG, PNG, TIFF, WebP, OpenEXR, HEIC, AVIF or raw image, by its first bytes";
  check_both(folder.with_file("text.jpg", "hello, world"), no_image);
  check_both(folder.with_file("text.txt", "hello, world"), no_image);
  check_both(folder.with_file("text", "hello, world"), no_image);
  const std::string unsound = "is damaged or cut off, a PNG without a sound header; copy it again";
  const std::string signature = "\x89PNG\r\n\x1a\n";
  CHECK_THROWS_WITH(photograph_size(folder.with_file("signature.png", signature)), Catch::EndsWith(unsound));
  CHECK_THROWS_WITH(photograph_size(folder.with_file("claim.png", signature + "\xff\xff\xff\xffIHDRxx")),
                    Catch::EndsWith(unsound));
  write_image(folder / "whole.png", position_pattern(4, 3, 8));
  const std::string whole = bytes_of(folder / "whole.png");
  for (std::size_t byte = 8; byte < 33; ++byte) {  // IHDR, whatever bit of it is wrong
    std::string damaged = whole;
    damaged[byte] = static_cast<char>(damaged[byte] ^ 1 << byte % 8);
    CHECK_THROWS_WITH(photograph_size(folder.with_file("damaged.png", damaged)), Catch::EndsWith(unsound));
  }
  check_both(folder.with_file("frameless.jpg", "\xff\xd8\xff\xd9"),
             "is damaged or cut off, a JPEG without a frame header");
}

TEST_CASE("a JPEG header with any byte changed gives a size or is refused") {
  const TemporaryFolder folder;
  write_oriented(folder / "a.jpg", position_pattern(32, 16, 16), 6);
  const std::string bytes = bytes_of(folder / "a.jpg");
  for (std::size_t at = 3; at < bytes.size(); ++at) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(~changed[at]);
    const fs::path path = folder.with_file("b.jpg", changed);
    CAPTURE(at);
    try {
      const ImageSize size = photograph_size(path);
      CHECK(std::uint64_t{size.width} * size.height > 0);
    } catch (const InputError& error) {
      CHECK_THAT(error.what(), Catch::StartsWith(path.string() + ": "));
    }
  }
}

// A JPEG's frame header, of the given process, then nothing.
std::string jpeg_that_claims(char process, const std::string& height_and_width) {
  return "\xff\xd8\xff" + (process + std::string("\0\x11\x08", 3)) + height_and_width +
         std::string("\x03\x01\x22\0\x02\x11\x01\x03\x11\x01\xff\xd9", 12);
}

TEST_CASE("a photograph that is replaced while it is read is the old one or the new one") {
  const TemporaryFolder folder;
  const bool jpeg = GENERATE(true, false);
  const std::string ending = jpeg ? ".jpg" : ".png";
  const Photograph small = position_pattern(40, 24, 8), large = position_pattern(200, 120, 8);
  write_image(folder / ("small" + ending), small);
  write_image(folder / ("large" + ending), large);
  const fs::path path = folder / ("photograph" + ending);
  fs::copy(folder / ("small" + ending), path);
  const Photograph read_small = read_photograph(folder / ("small" + ending));
  const Photograph read_large = read_photograph(folder / ("large" + ending));
  std::atomic<bool> done{false};
  std::thread replacer([&] {
    for (bool next_is_large = true; !done; next_is_large = !next_is_large) {
      fs::copy(folder / ((next_is_large ? "large" : "small") + ending), folder / "pending");
      fs::rename(folder / "pending", path);
    }
  });
  std::size_t neither = 0, read_whole = 0;
  for (int times = 0; times < 400; ++times) {
    try {
      const Photograph read = read_photograph(path);
      const Photograph& expected = read.width == small.width ? read_small : read_large;
      neither += read.width == expected.width && read.height == expected.height && read.rgb == expected.rgb ? 0 : 1;
      ++read_whole;
    } catch (const InputError&) {  // its length was asked for before it was replaced
    }
  }
  done = true;
  replacer.join();
  CHECK(neither == 0);
  CHECK(read_whole > 0);
}

TEST_CASE("files that are no photographs are refused by their first bytes, whatever their names say") {
  const TemporaryFolder folder;
  const std::string reason = ": is no JPEG, PNG, TIFF, WebP, OpenEXR, HEIC, AVIF or raw image, by its first bytes";
  const std::string_view first_bytes =
      GENERATE(std::string_view("BM\x3a\0\0\0\0\0\0\0\x36\0", 12), "GIF89a\1\0\1\0\0\0",
               std::string_view("\0\0\1\0\1\0\x10\x10\0\0\1\0", 12), "SDPX\0\0\x8\0V1.0", "#?RADIANCE\n\n",
               "FOR4xxxxCIMG", "P6 1 1 255 abc", "RIFFxxxxWAVE", "8BPS");
  for (const char* ending : {".jpg", ".ico", ".dpx", ".iff", ".bmp", ".gif", ".hdr", ".tga", ".ppm", ".psd", ""}) {
    const fs::path path =
        folder.with_file(std::string("a") + ending, std::string(first_bytes) + std::string(1600, 'x'));
    CHECK_THROWS_WITH(photograph_size(path), path.string() + reason);
    CHECK_THROWS_WITH(read_photograph(path), path.string() + reason);
  }
}

TEST_CASE("a WebP photograph is read") {
  const TemporaryFolder folder;
  const Photograph image = position_pattern(48, 32, 16);
  write_image(folder / "a.webp", image);
  CHECK(photograph_size(folder / "a.webp").width == 48);
  const Photograph again = read_photograph(folder / "a.webp");
  REQUIRE(again.height == 32);
  CHECK(std::abs(pixel(again, 8, 8)[0] - pixel(image, 8, 8)[0]) <= 12);  // lossy
}

TEST_CASE("a claimed size that the file cannot hold is refused before anything is allocated") {
  const TemporaryFolder folder;
  const char process = GENERATE('\xc0', '\xc2');  // baseline, progressive
  const fs::path path = folder.with_file("a.jpg", jpeg_that_claims(process, "\xff\xdc\xff\xdc"));
  CHECK_THROWS_WITH(photograph_size(path),
                    path.string() + ": claims 65500x65500 pixels, which its 23 bytes cannot hold");
  CHECK_THROWS_WITH(read_photograph(path), Catch::Contains("claims 65500x65500 pixels"));
  const fs::path flat = folder.with_file("b.jpg", jpeg_that_claims(process, std::string("\0\0\0\x10", 4)));
  CHECK_THROWS_WITH(photograph_size(flat), flat.string() + ": 16x0 pixels, there is nothing in it");
}

std::string little_endian(std::uint32_t value, std::size_t bytes) {
  std::string text;
  for (std::size_t at = 0; at < bytes; ++at) text += static_cast<char>(value >> 8 * at & 0xff);
  return text;
}

// The head of a WebP file that claims this size, in each of the three ways to say so, then 200 bytes of nothing.
std::string webp_that_claims(const std::string& kind, std::uint32_t width, std::uint32_t height) {
  std::string data(200, '\0');
  if (kind == "VP8X") data.replace(4, 6, little_endian(width - 1, 3) + little_endian(height - 1, 3));
  if (kind == "VP8L") data.replace(0, 5, "\x2f" + little_endian((width - 1) | (height - 1) << 14, 4));
  if (kind == "VP8 ") data.replace(3, 7, "\x9d\x01\x2a" + little_endian(width | height << 16, 4));
  return "RIFF" + little_endian(static_cast<std::uint32_t>(data.size() + 12), 4) + "WEBP" + kind +
         little_endian(static_cast<std::uint32_t>(data.size()), 4) + data;
}

TEST_CASE("a WebP picture that claims more than its bytes can hold is refused before OpenImageIO allocates it") {
  const TemporaryFolder folder;
  const std::string kind = GENERATE("VP8X", "VP8L", "VP8 ");
  const fs::path path = folder.with_file("a.webp", webp_that_claims(kind, 15884, 14591));
  const std::string reason = ": claims 15884x14591 pixels, which its 220 bytes cannot hold";
  CHECK_THROWS_WITH(photograph_size(path), path.string() + reason);
  CHECK_THROWS_WITH(read_photograph(path), path.string() + reason);
}

TEST_CASE("a WebP file whose first chunk holds no size is refused") {
  const TemporaryFolder folder;
  std::string bytes = webp_that_claims("VP8 ", 16, 16);
  SECTION("for it is of an unknown kind") {
    bytes.replace(12, 4, "ICCP");
  }
  SECTION("for it lacks its start code") {
    bytes[23] = '\0';
  }
  SECTION("for it is cut off") {
    bytes.resize(29);
  }
  const fs::path path = folder.with_file("a.webp", bytes);
  CHECK_THROWS_WITH(photograph_size(path), path.string() +
                                               ": is damaged or cut off, a WebP file without a sound header; copy it "
                                               "again");
}

// libpng would tell the terminal too.
TEST_CASE("a PNG with a changed byte among its pixels is refused by its checksum") {
  const TemporaryFolder folder;
  write_image(folder / "whole.png", position_pattern(16, 12, 2));
  std::string damaged = bytes_of(folder / "whole.png");
  damaged.at(damaged.find("IDAT") + 9) ^= 0x55;
  CHECK_THROWS_WITH(read_photograph(folder.with_file("damaged.png", damaged)),
                    Catch::EndsWith("is damaged, its pixels do not have their checksum; copy it again"));
}

TEST_CASE("an OpenEXR attribute that claims more bytes than the file has is refused before it is allocated") {
  const TemporaryFolder folder;
  const std::string claim("\x76\x2f\x31\x01\x02\0\0\0owner\0text\0\0\0\0\x70x\0", 25);
  for (const std::string& file : {claim, claim.substr(0, 21), claim.substr(0, 10)}) {
    CHECK_THROWS_WITH(photograph_size(folder.with_file("claim.exr", file)),
                      Catch::EndsWith("is damaged or cut off, an OpenEXR file without a sound header; copy it again"));
  }
}

// Found by fuzzing: OpenEXR allocated 862 MB for a few lines while it opened a file of 639 bytes.
TEST_CASE("an OpenEXR file that claims more pixels than it can hold is refused before they are allocated") {
  const fs::path fuzzed = fs::path(LUMATLAS_FUZZED_PICTURES) / "claims-exr";
  CHECK_THROWS_WITH(photograph_size(fuzzed), Catch::EndsWith("8978433x1 pixels, more than 65536 a side"));

  const TemporaryFolder folder;
  write_image(folder / "whole.exr", position_pattern(4, 3));
  const std::string whole = bytes_of(folder / "whole.exr");
  const std::size_t window = whole.find(std::string("dataWindow\0box2i\0", 17)) + 17 + 4;
  const auto with_window = [&](std::uint32_t left, std::uint32_t right, std::uint32_t bottom) {
    std::string bytes = whole;
    bytes.replace(window, 16,
                  little_endian(left, 4) + little_endian(0, 4) + little_endian(right, 4) + little_endian(bottom, 4));
    return folder.with_file("a.exr", bytes);
  };
  const std::string cannot_hold = std::to_string(whole.size()) + " bytes cannot hold";
  CHECK(photograph_size(with_window(0, 3, 2)).height == 3);
  CHECK_THROWS_WITH(photograph_size(with_window(0, 65535, 65535)),
                    Catch::Contains("claims 65536x65536 pixels") && Catch::EndsWith(cannot_hold));
  CHECK_THROWS_WITH(photograph_size(with_window(0, 65535, 0)),
                    Catch::Contains(" in blocks of 256 lines") && Catch::EndsWith(cannot_hold));
  CHECK_THROWS_WITH(photograph_size(with_window(4, 3, 2)), Catch::EndsWith("0x3 pixels, there is nothing in it"));
  CHECK_THROWS_WITH(photograph_size(with_window(0x80000000, 0x7FFFFFFF, 2)),
                    Catch::EndsWith("4294967296x3 pixels, more than 65536 a side"));

  const auto with_tiles = [&](std::uint32_t width, std::uint32_t height) {
    const std::string tiles = std::string("tiles\0tiledesc\0", 15) + little_endian(9, 4) + little_endian(width, 4) +
                              little_endian(height, 4) + '\0';
    return folder.with_file("tiles.exr", whole.substr(0, 8) + tiles + whole.substr(8));
  };
  CHECK(photograph_size(with_tiles(64, 64)).width == 4);
  CHECK_THROWS_WITH(photograph_size(with_tiles(70000, 64)), Catch::EndsWith("more than 65536 a side"));
  CHECK_THROWS_WITH(photograph_size(with_tiles(40000, 40000)), Catch::Contains(" in blocks of 40000 lines"));
}

// OpenEXR would go on after the channels, or the preview, at another place than their sizes say.
TEST_CASE("an OpenEXR attribute that is not as large as its type is refused before it is decoded") {
  const TemporaryFolder folder;
  write_image(folder / "whole.exr", position_pattern(4, 3));
  const std::string whole = bytes_of(folder / "whole.exr");
  CHECK(read_photograph(folder / "whole.exr").width == 4);
  const auto check_refused = [&](const std::string& bytes) {
    CHECK_THROWS_WITH(photograph_size(folder.with_file("a.exr", bytes)),
                      Catch::EndsWith("is damaged or cut off, an OpenEXR file without a sound header; copy it again"));
  };
  std::string misnamed = whole;  // the name of the second channel has become a longer one
  const std::size_t channels = whole.find(std::string("chlist\0", 7)) + 7 + 4;
  misnamed.at(channels + 1) = 'x';
  check_refused(misnamed);
  const auto with_attribute = [&](const std::string& type, const std::string& value) {
    const std::string attribute =
        std::string("x\0", 2) + type + '\0' + little_endian(static_cast<std::uint32_t>(value.size()), 4) + value;
    return whole.substr(0, 8) + attribute + whole.substr(8);
  };
  check_refused(with_attribute("preview", little_endian(50000, 4) + little_endian(40000, 4)));
  check_refused(with_attribute("preview", little_endian(1, 4)));
  check_refused(with_attribute("float", std::string(8, '\0')));
  check_refused(with_attribute("m44f", ""));
  CHECK(photograph_size(folder.with_file("b.exr", with_attribute("string", "any"))).width == 4);
  CHECK(photograph_size(folder.with_file("b.exr", with_attribute("ours", "any"))).width == 4);
}

// Found by fuzzing: OpenImageIO ended the program once what it said of each row was more than 16 MB.
TEST_CASE("a TIFF in which tens of thousands of rows are damaged is refused in one sentence") {
  const fs::path path = fs::path(LUMATLAS_FUZZED_PICTURES) / "many-errors-tif";
  CHECK(photograph_size(path, Orientation::as_stored).height > 60000);
  CHECK_THROWS_WITH(read_photograph(path), Catch::StartsWith(path.string() + ": is damaged or cut off ("));
}

TEST_CASE("a tiled TIFF of several bands of rows is read as it was written") {
  const TemporaryFolder folder;
  OIIO::ImageSpec spec(70, 700, 3, TypeDesc::UINT8);
  spec.tile_width = 32;
  spec.tile_height = 48;
  std::vector<std::uint8_t> pixels;
  for (std::size_t at = 0; at < std::size_t{3} * 70 * 700; ++at) pixels.push_back(static_cast<std::uint8_t>(at % 251));
  const auto output = OIIO::ImageOutput::create("a.tif");
  REQUIRE(output->open((folder / "a.tif").string(), spec));
  REQUIRE(output->write_image(TypeDesc::UINT8, pixels.data()));
  REQUIRE(output->close());
  CHECK(read_photograph(folder / "a.tif").rgb == pixels);
}

TEST_CASE("more than 65536 pixels a side are refused") {
  const TemporaryFolder folder;
  const std::vector<std::uint8_t> row(3 * 65537, 9);
  write_stored(folder / "a.tif", OIIO::ImageSpec(65537, 1, 3, TypeDesc::UINT8), TypeDesc::UINT8, row.data());
  CHECK_THROWS_WITH(photograph_size(folder / "a.tif"),
                    (folder / "a.tif").string() + ": 65537x1 pixels, more than 65536 a side");
}

std::size_t files_in(const TemporaryFolder& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder.path()), {}));
}

TEST_CASE("an image is written whole or not at all") {
  const TemporaryFolder folder;
  const Photograph image = position_pattern(5, 3);
  write_image(folder / "a.png", position_pattern(2, 2));
  write_image(folder / "a.png", image);
  CHECK(read_photograph(folder / "a.png").rgb == image.rgb);
  CHECK(files_in(folder) == 1);
  fs::create_directory(folder / "taken.png");
  CHECK_THROWS_AS(write_image(folder / "taken.png", image), InputError);
  CHECK(files_in(folder) == 2);
}

TEST_CASE("an image that cannot be written is refused by name") {
  const TemporaryFolder folder;
  const Photograph image = position_pattern(5, 3);
  CHECK_THROWS_WITH(write_image(folder / "a.xyz", image),
                    (folder / "a.xyz").string() + ": no image format is known by the ending '.xyz'; use .png or .jpg");
  CHECK_THROWS_WITH(write_image(folder / "none/a.png", image),
                    (folder / "none/a.png").string() + ": cannot be written, its folder does not exist");
  Photograph bad = image;
  bad.rgb.pop_back();
  CHECK_THROWS_MATCHES(write_image(folder / "a.png", bad), std::invalid_argument,
                       Catch::Message("image.rgb has 44 bytes; it must have 45 (3 * width * height)"));
  bad.width = 0;
  CHECK_THROWS_MATCHES(write_image(folder / "a.png", bad), std::invalid_argument,
                       Catch::Message("image size is 0x3; each side must be in [1, 65536]"));
  CHECK(files_in(folder) == 0);
}

}  // namespace
}  // namespace lumatlas
