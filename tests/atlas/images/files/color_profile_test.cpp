// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs whose files say that their numbers are other colours than sRGB's.
#include <OpenImageIO/imageio.h>
#include <lcms2.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "atlas/images/photograph.h"
#include "tests/support/profiled_pictures.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of_profile(cmsHPROFILE profile) {
  REQUIRE(profile);
  cmsUInt32Number size = 0;
  REQUIRE(cmsSaveProfileToMem(profile, nullptr, &size));
  Bytes bytes(size);
  REQUIRE(cmsSaveProfileToMem(profile, bytes.data(), &size));
  cmsCloseProfile(profile);
  return bytes;
}

// A profile by its white and primaries (CIE x and y) and its curve.
Bytes rgb_profile(const cmsCIExyYTRIPLE& primaries, cmsToneCurve* curve) {
  const cmsCIExyY white{0.3127, 0.3290, 1};
  const std::array<cmsToneCurve*, 3> curves{curve, curve, curve};
  cmsHPROFILE profile = cmsCreateRGBProfile(&white, &primaries, curves.data());
  cmsFreeToneCurve(curve);
  return bytes_of_profile(profile);
}

cmsToneCurve* srgb_curve() {
  const std::array<cmsFloat64Number, 5> p{2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
  return cmsBuildParametricToneCurve(nullptr, 4, p.data());
}

Bytes display_p3() {
  return rgb_profile({{0.680, 0.320, 1}, {0.265, 0.690, 1}, {0.150, 0.060, 1}}, srgb_curve());
}

Bytes adobe_rgb() {
  return rgb_profile({{0.64, 0.33, 1}, {0.21, 0.71, 1}, {0.15, 0.06, 1}}, cmsBuildGamma(nullptr, 563 / 256.0));
}

Bytes grey_profile(double gamma) {
  const cmsCIExyY white{0.3127, 0.3290, 1};
  cmsToneCurve* const curve = cmsBuildGamma(nullptr, gamma);
  cmsHPROFILE profile = cmsCreateGrayProfile(&white, curve);
  cmsFreeToneCurve(curve);
  return bytes_of_profile(profile);
}

// An 8-bit picture of one colour with the profile in it.
void write_tagged(const fs::path& path, const std::vector<std::uint8_t>& color, const Bytes& profile) {
  constexpr int kSide = 16;
  const auto output = OIIO::ImageOutput::create(path.string());
  OIIO::ImageSpec spec(kSide, kSide, static_cast<int>(color.size()), OIIO::TypeDesc::UINT8);
  spec.attribute("CompressionQuality", 100);
  spec.attribute("ICCProfile", OIIO::TypeDesc(OIIO::TypeDesc::UINT8, static_cast<int>(profile.size())), profile.data());
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < kSide * kSide; ++i) pixels.insert(pixels.end(), color.begin(), color.end());
  REQUIRE(output->open(path.string(), spec));
  REQUIRE(output->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
  REQUIRE(output->close());
}

glm::ivec3 color_of(const fs::path& path) {
  const Photograph read = read_photograph(path);
  return {read.rgb[0], read.rgb[1], read.rgb[2]};
}

int difference(const glm::ivec3& a, const glm::ivec3& b) {
  return std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)});
}

// The matrices of https://www.w3.org/TR/css-color-4/#color-conversion-code, from linear light to linear light.
glm::ivec3 srgb_of(const glm::ivec3& color, const glm::dmat3& srgb_from_other, double gamma) {
  glm::dvec3 linear;
  for (int c = 0; c < 3; ++c) {
    const double encoded = color[c] / 255.0;
    linear[c] = gamma > 0 ? std::pow(encoded, gamma)
                          : (encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4));
  }
  linear = srgb_from_other * linear;
  glm::ivec3 result;
  for (int c = 0; c < 3; ++c) {
    const double x = std::clamp(linear[c], 0.0, 1.0);
    const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
    result[c] = static_cast<int>(std::lround(255 * encoded));
  }
  return result;
}

// One column after the other.
const glm::dmat3 kFromP3({1.2249401763, -0.0420569547, -0.0196375546}, {-0.2249401763, 1.0420569547, -0.0786360455},
                         {0, 0, 1.0982736001});
const glm::dmat3 kFromAdobe({1.3982832, 0, 0}, {-0.3982832, 1, -0.0429383}, {0, 0, 1.0429383});

// Within four levels: of rounding at three places, and of JPEG at quality 100.
constexpr int kRounding = 4;

TEST_CASE("colours of Display P3 and Adobe RGB become those of sRGB") {
  const TemporaryFolder folder;
  for (const char* const ending : {"png", "jpg", "tif"}) {
    for (const glm::ivec3& color : {glm::ivec3(200, 120, 90), {90, 140, 80}, {128, 128, 128}, {30, 60, 200}}) {
      CAPTURE(ending, color.x, color.y, color.z);
      const fs::path path = folder / (std::string("a.") + ending);
      const std::vector<std::uint8_t> bytes{static_cast<std::uint8_t>(color.x), static_cast<std::uint8_t>(color.y),
                                            static_cast<std::uint8_t>(color.z)};
      write_tagged(path, bytes, display_p3());
      CHECK(difference(color_of(path), srgb_of(color, kFromP3, 0)) <= kRounding);
      write_tagged(path, bytes, adobe_rgb());
      CHECK(difference(color_of(path), srgb_of(color, kFromAdobe, 563 / 256.0)) <= kRounding);
    }
  }
}

TEST_CASE("a photograph that says that it is sRGB stays as it is, to the byte") {
  const TemporaryFolder folder;
  const Bytes srgb = bytes_of_profile(cmsCreate_sRGBProfile());
  for (int level = 0; level < 256; level += 5) {
    const auto byte = static_cast<std::uint8_t>(level);
    write_tagged(folder / "a.png", {byte, 7, 200}, srgb);
    CHECK(color_of(folder / "a.png") == glm::ivec3(level, 7, 200));
  }
}

TEST_CASE("a grey photograph is shown as its profile says") {
  const TemporaryFolder folder;
  write_tagged(folder / "a.png", {100}, grey_profile(1.8));
  const glm::ivec3 expected = srgb_of(glm::ivec3(100), glm::dmat3(1), 1.8);
  CHECK(difference(color_of(folder / "a.png"), expected) <= 1);
}

TEST_CASE("a profile that is damaged, or of another kind than the picture, changes nothing") {
  const TemporaryFolder folder;
  Bytes damaged = display_p3();
  damaged.resize(damaged.size() / 2);
  for (const Bytes& profile : {Bytes(200, 7), damaged, bytes_of_profile(cmsCreateLab4Profile(nullptr))}) {
    write_tagged(folder / "a.jpg", {128, 128, 128}, profile);
    CHECK(color_of(folder / "a.jpg") == glm::ivec3(128));
  }
  write_tagged(folder / "a.jpg", {200, 120, 90}, grey_profile(1.8));  // libpng writes no such PNG
  CHECK(difference(color_of(folder / "a.jpg"), {200, 120, 90}) <= kRounding);
}

const glm::ivec3 kStoredColor(200, 120, 90);  // kProfiledColor

// Reads the photograph, its size and its camera, from the file and from memory.
void check_is_read(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
  CHECK(photograph_size(path).width == kProfiledSide);
  CHECK(read_photograph(path).width == kProfiledSide);
  CHECK(read_camera_note(path).size.height == kProfiledSide);
  CHECK(read_alpha(path).empty());
  if (path.extension() != ".png") return;
  const std::span file(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  CHECK(photograph_size(file, "name").width == kProfiledSide);
  CHECK(read_photograph(file, "name").width == kProfiledSide);
}

std::string text_of(const Bytes& bytes) {
  return {bytes.begin(), bytes.end()};
}

TEST_CASE("every byte of a profile may be any other: the picture is read") {
  const TemporaryFolder folder;
  const Bytes profile = display_p3();
  for (std::size_t at = 0; at < profile.size(); ++at) {
    CAPTURE(at);
    Bytes changed = profile;
    changed[at] = static_cast<std::uint8_t>(profile[at] ^ 0x80);
    check_is_read(folder / "a.png", png_with_profile(text_of(changed)));
    check_is_read(folder / "a.tif", tiff_with_profile(text_of(changed)));
    if (at % 3 != 0) continue;
    changed[at] = static_cast<std::uint8_t>(profile[at] ^ 0x5a);
    write_tagged(folder / "a.jpg", {10, 20, 30}, changed);
    CHECK(read_photograph(folder / "a.jpg").width == 16);
  }
}

TEST_CASE("a profile may be cut off anywhere: the picture is read") {
  const TemporaryFolder folder;
  const std::string profile = text_of(display_p3());
  for (std::size_t size = 0; size < profile.size(); size += 5) {
    check_is_read(folder / "a.png", png_with_profile(profile.substr(0, size)));
    check_is_read(folder / "a.tif", tiff_with_profile(profile.substr(0, size)));
  }
}

TEST_CASE("the packed profile of a PNG may be damaged: the colours are taken as sRGB") {
  const TemporaryFolder folder;
  const std::string packed = deflated(text_of(display_p3()));
  const std::string header("name\0\0", 6);
  for (const std::string& chunk :
       {std::string(), std::string("name"), header, header + "no packed bytes", header + packed.substr(0, 40)}) {
    std::ofstream(folder / "a.png", std::ios::binary) << png_with_profile_chunk(chunk);
    CHECK(color_of(folder / "a.png") == kStoredColor);
  }
}

TEST_CASE("a profile is found in every kind of TIFF file") {
  const TemporaryFolder folder;
  const std::string profile = text_of(adobe_rgb());
  const glm::ivec3 expected = srgb_of(kStoredColor, kFromAdobe, 563 / 256.0);
  REQUIRE(difference(expected, kStoredColor) > 2 * kRounding);
  for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) {
    for (const bool big_tiff : {false, true}) {
      CAPTURE(order == ByteOrder::big, big_tiff);
      std::ofstream(folder / "a.tif", std::ios::binary) << tiff_with_profile(profile, order, big_tiff);
      CHECK(difference(color_of(folder / "a.tif"), expected) <= kRounding);
    }
  }
}

// A WebP file of 16 x 16 pixels of kStoredColor, with the profile.
std::string profiled_webp(const TemporaryFolder& folder, const std::string& profile) {
  constexpr std::uint32_t kSide = 16;
  const fs::path plain = folder / "plain.webp";
  if (!fs::exists(plain)) {
    Photograph image{kSide, kSide, {}, {}};
    for (std::uint32_t i = 0; i < kSide * kSide; ++i) image.rgb.insert(image.rgb.end(), {200, 120, 90});
    write_image(plain, image);
  }
  return webp_with_profile(bytes_of(plain), kSide, kSide, profile);
}

TEST_CASE("the colours of a WebP photograph become sRGB by its profile") {
  const TemporaryFolder folder;
  // Within six levels: the pixels are lossy, at a quality that others choose.
  constexpr int kLossy = 6;
  (void)folder.with_file("p3.webp", profiled_webp(folder, text_of(display_p3())));
  CHECK(difference(color_of(folder / "p3.webp"), srgb_of(kStoredColor, kFromP3, 0)) <= kLossy);
  (void)folder.with_file("adobe.webp", profiled_webp(folder, text_of(adobe_rgb())));
  const glm::ivec3 expected = srgb_of(kStoredColor, kFromAdobe, 563 / 256.0);
  REQUIRE(difference(expected, kStoredColor) > 2 * kLossy);
  CHECK(difference(color_of(folder / "adobe.webp"), expected) <= kLossy);
  CHECK(difference(color_of(folder / "plain.webp"), kStoredColor) <= kLossy);
}

TEST_CASE("the profile of a WebP photograph may be damaged, cut off or larger than it says: the picture is read") {
  const TemporaryFolder folder;
  const std::string profile = text_of(display_p3());
  const auto is_read = [&](const std::string& bytes) {
    return read_photograph(folder.with_file("a.webp", bytes)).width == 16;
  };
  for (std::size_t at = 0; at < profile.size(); at += 3) {
    CAPTURE(at);
    std::string changed = profile;
    changed[at] = static_cast<char>(changed[at] ^ 0x80);
    CHECK(is_read(profiled_webp(folder, changed)));
    CHECK(is_read(profiled_webp(folder, profile.substr(0, at))));
  }
  std::string long_chunk = profiled_webp(folder, profile);
  long_chunk.replace(long_chunk.find("ICCP") + 4, 4, "\xff\xff\xff\xff");
  CHECK_THROWS_WITH(is_read(long_chunk), Catch::Contains("a.webp: "));
}

TEST_CASE("a profile that unpacks to more than 8 MiB is left alone") {
  const TemporaryFolder folder;
  std::string large = text_of(adobe_rgb());
  large.resize(9 << 20);
  std::ofstream(folder / "a.png", std::ios::binary) << png_with_profile(large);
  CHECK(color_of(folder / "a.png") == kStoredColor);
}

}  // namespace
}  // namespace lumatlas
