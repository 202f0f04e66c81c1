// SPDX-License-Identifier: GPL-3.0-or-later
// HEIC, AVIF and raw photographs, all made here: HEIC and AVIF by libheif, a DNG by hand.
#include <lcms2.h>
#include <libheif/heif.h>

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "atlas/images/photograph.h"
#include "mesh/base/errors.h"
#include "tests/support/skip.h"
#include "tests/support/temporary_folder.h"

// Hooks of AddressSanitizer: the encoders, which only this test uses, keep memory at the end.
extern "C" const char* __lsan_default_suppressions();   // NOLINT(bugprone-reserved-identifier)
extern "C" const char* __lsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier)
  return "leak:libx265\nleak:libheif";
}

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using Level3 = std::array<int, 3>;

constexpr int kFormWidth = 96, kFormHeight = 64;

// Four rectangles, each of one colour: top left, top right, bottom left, bottom right.
constexpr std::array<Level3, 4> kQuarters{{{200, 60, 50}, {60, 180, 70}, {50, 70, 190}, {128, 128, 128}}};

const Level3& quarter_at(int x, int y) {
  return kQuarters.at((y < kFormHeight / 2 ? 0u : 2u) + (x < kFormWidth / 2 ? 0u : 1u));
}

Level3 level_at(const Photograph& photo, std::uint32_t x, std::uint32_t y) {
  const std::size_t at = 3 * (std::size_t{y} * photo.width + x);
  return {photo.rgb.at(at), photo.rgb.at(at + 1), photo.rgb.at(at + 2)};
}

// The centres of the quarters of the photograph as it was read.
std::array<Level3, 4> quarters_of(const Photograph& photo) {
  const std::uint32_t left = photo.width / 4, right = 3 * photo.width / 4;
  const std::uint32_t top = photo.height / 4, bottom = 3 * photo.height / 4;
  return {level_at(photo, left, top), level_at(photo, right, top), level_at(photo, left, bottom),
          level_at(photo, right, bottom)};
}

void check_quarters(const Photograph& photo, const std::array<Level3, 4>& expected, int tolerance) {
  const std::array<Level3, 4> found = quarters_of(photo);
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      INFO("quarter " << i << ", channel " << channel << ": " << found[i][channel]);
      CHECK(std::abs(found[i][channel] - expected[i][channel]) <= tolerance);
    }
  }
}

std::string refusal(const fs::path& path) {
  try {
    (void)read_photograph(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

struct HeifForm {
  heif_compression_format coding = heif_compression_HEVC;
  int turned = 1;  // as EXIF counts; the file says it in its own way, and in EXIF too
  bool ten_bits = false, alpha = false;
  std::vector<std::uint8_t> profile;
  heif_color_primaries primaries = heif_color_primaries_unspecified;
};

// A TIFF structure with the camera's maker and an orientation.
std::string exif_of_photograph(int orientation) {
  std::string exif(
      "II*\0\x08\0\0\0\x02\0\x0f\x01\x02\0\x04\0\0\0"
      "Acm\0",
      22);
  exif += std::string("\x12\x01\x03\0\x01\0\0\0", 8) + static_cast<char>(orientation);
  return exif + std::string(7, '\0');
}

void fill_heif(heif_image* image, const HeifForm& form) {
  const int samples = form.alpha ? 4 : 3;
  int stride = 0;
  std::uint8_t* const plane = heif_image_get_plane(image, heif_channel_interleaved, &stride);
  for (int y = 0; y < kFormHeight; ++y) {
    for (int x = 0; x < kFormWidth; ++x) {
      for (int channel = 0; channel < samples; ++channel) {
        const int value = channel == 3 ? (x < kFormWidth / 2 ? 255 : 0) : quarter_at(x, y)[std::size_t(channel)];
        const int sample = samples * x + channel;
        if (form.ten_bits) {
          const int wide = value * 1023 / 255;
          plane[y * stride + 2 * sample] = static_cast<std::uint8_t>(wide & 255);
          plane[y * stride + 2 * sample + 1] = static_cast<std::uint8_t>(wide >> 8);
        } else {
          plane[y * stride + sample] = static_cast<std::uint8_t>(value);
        }
      }
    }
  }
}

heif_error to_file(heif_context*, const void* data, std::size_t size, void* text) {
  static_cast<std::string*>(text)->assign(static_cast<const char*>(data), size);
  return {heif_error_Ok, heif_suberror_Unspecified, "ok"};
}

void require_done(const heif_error& error) {
  INFO(error.message);
  REQUIRE(error.code == heif_error_Ok);
}

// Empty where this machine's libheif does not encode the coding.
std::string heif_file(const HeifForm& form) {
  const std::unique_ptr<heif_context, decltype(&heif_context_free)> context(heif_context_alloc(), heif_context_free);
  heif_encoder* made = nullptr;
  if (heif_context_get_encoder_for_format(context.get(), form.coding, &made).code != heif_error_Ok) return {};
  const std::unique_ptr<heif_encoder, decltype(&heif_encoder_release)> encoder(made, heif_encoder_release);
  heif_encoder_set_lossy_quality(made, 95);
  heif_image* image = nullptr;
  const heif_chroma chroma = form.ten_bits ? heif_chroma_interleaved_RRGGBB_LE
                             : form.alpha  ? heif_chroma_interleaved_RGBA
                                           : heif_chroma_interleaved_RGB;
  require_done(heif_image_create(kFormWidth, kFormHeight, heif_colorspace_RGB, chroma, &image));
  const std::unique_ptr<heif_image, decltype(&heif_image_release)> kept(image, heif_image_release);
  require_done(heif_image_add_plane(image, heif_channel_interleaved, kFormWidth, kFormHeight, form.ten_bits ? 10 : 8));
  fill_heif(image, form);
  if (!form.profile.empty()) {
    require_done(heif_image_set_raw_color_profile(image, "prof", form.profile.data(), form.profile.size()));
  }
  const std::unique_ptr<heif_color_profile_nclx, decltype(&heif_nclx_color_profile_free)> nclx(
      heif_nclx_color_profile_alloc(), heif_nclx_color_profile_free);
  if (form.primaries != heif_color_primaries_unspecified) {
    require_done(heif_nclx_color_profile_set_color_primaries(nclx.get(), static_cast<std::uint16_t>(form.primaries)));
    require_done(heif_image_set_nclx_color_profile(image, nclx.get()));
  }
  const std::unique_ptr<heif_encoding_options, decltype(&heif_encoding_options_free)> options(
      heif_encoding_options_alloc(), heif_encoding_options_free);
  options->macOS_compatibility_workaround_no_nclx_profile = 0;
  options->image_orientation = static_cast<heif_orientation>(form.turned);
  heif_image_handle* handle = nullptr;
  require_done(heif_context_encode_image(context.get(), image, made, options.get(), &handle));
  const std::string exif = exif_of_photograph(form.turned);
  require_done(heif_context_add_exif_metadata(context.get(), handle, exif.data(), static_cast<int>(exif.size())));
  heif_image_handle_release(handle);
  std::string file;
  heif_writer writer{1, to_file};
  require_done(heif_context_write(context.get(), &writer, &file));
  return file;
}

// Returns nothing, and skips the case, if libheif does not encode the form.
std::optional<fs::path> written_heif(const TemporaryFolder& folder, const std::string& name, const HeifForm& form) {
  const std::string file = heif_file(form);
  if (!file.empty()) return folder.with_file(name, file);
  skip(std::string("libheif does not encode ") + (form.coding == heif_compression_HEVC ? "HEIC" : "AVIF"));
  return std::nullopt;
}

// The properties that a DNG states of its photograph.
struct DngForm {
  std::array<double, 3> neutral{1, 1, 1};  // the sensor's values of white
  int orientation = 1;
  bool big_endian = false;
};

double linear_light(int level) {
  const double v = level / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

// A DNG file: entries of one directory, then what they point to, then the sensor's values behind RGGB filters.
class DngWriter {
 public:
  explicit DngWriter(const DngForm& form) : form_(form) {}

  std::string file() {
    constexpr int kByte = 1, kAscii = 2, kShort = 3, kLong = 4, kRational = 5, kSignedRational = 10;
    // From XYZ of D65 to linear sRGB (IEC 61966-2-1), which this sensor sees as it is.
    constexpr std::array kFromXyz{32406, -15372, -4986, -9689, 18758, 415, 557, -2040, 10570};
    std::string matrix, neutral;
    for (const int value : kFromXyz) matrix += number(value, 4) + number(10000, 4);
    for (const double value : form_.neutral) neutral += number(std::lround(value * 10000), 4) + number(10000, 4);
    add(254, kLong, 1, number(0, 4));
    add(256, kLong, 1, number(kFormWidth, 4));
    add(257, kLong, 1, number(kFormHeight, 4));
    add(258, kShort, 1, number(16, 2));
    add(259, kShort, 1, number(1, 2));
    add(262, kShort, 1, number(32803, 2));
    add(271, kAscii, 5, std::string("Acme\0", 5));
    add(272, kAscii, 4, std::string("One\0", 4));
    add(273, kLong, 1, number(kPixels, 4));
    add(274, kShort, 1, number(form_.orientation, 2));
    add(277, kShort, 1, number(1, 2));
    add(278, kLong, 1, number(kFormHeight, 4));
    add(279, kLong, 1, number(2 * kFormWidth * kFormHeight, 4));
    add(284, kShort, 1, number(1, 2));
    add(33421, kShort, 2, number(2, 2) + number(2, 2));
    add(33422, kByte, 4, std::string("\0\1\1\2", 4));
    add(50706, kByte, 4, std::string("\1\4\0\0", 4));
    add(50708, kAscii, 9, std::string("Acme One\0", 9));
    add(50717, kLong, 1, number(65535, 4));
    add(50721, kSignedRational, 9, matrix);
    add(50728, kRational, 3, neutral);
    add(50778, kShort, 1, number(21, 2));
    std::string file = form_.big_endian ? "MM" : "II";
    file += number(42, 2) + number(8, 4) + number(count_, 2) + entries_ + number(0, 4);
    file.resize(kOutside, '\0');
    file += outside_;
    file.resize(kPixels, '\0');
    return file + pixels();
  }

 private:
  static constexpr std::size_t kOutside = 512, kPixels = 1024;  // bytes from the start of the file

  [[nodiscard]] std::string number(long value, int bytes) const {
    std::string text;
    for (int i = 0; i < bytes; ++i) {
      text += static_cast<char>(static_cast<unsigned long>(value) >> 8 * (form_.big_endian ? bytes - 1 - i : i) & 255);
    }
    return text;
  }
  void add(int tag, int type, int count, std::string value) {
    ++count_;
    entries_ += number(tag, 2) + number(type, 2) + number(count, 4);
    if (value.size() > 4) {
      entries_ += number(static_cast<long>(kOutside + outside_.size()), 4);
      outside_ += value;
      if (outside_.size() % 2 != 0) outside_ += '\0';
      return;
    }
    value.resize(4, '\0');
    entries_ += value;
  }
  [[nodiscard]] std::string pixels() const {
    std::string text;
    for (int y = 0; y < kFormHeight; ++y) {
      for (int x = 0; x < kFormWidth; ++x) {
        const auto channel = static_cast<std::size_t>(x % 2 + y % 2);
        const double light = linear_light(quarter_at(x, y).at(channel)) * form_.neutral.at(channel);
        text += number(std::lround(light * 65535), 2);
      }
    }
    return text;
  }

  DngForm form_;
  int count_ = 0;
  std::string entries_, outside_;
};

std::string dng_file(const DngForm& form) {
  return DngWriter(form).file();
}

// ICC's bytes of Display P3.
std::vector<std::uint8_t> display_p3_bytes() {
  const cmsCIExyY white{0.3127, 0.3290, 1};
  const cmsCIExyYTRIPLE primaries{{0.680, 0.320, 1}, {0.265, 0.690, 1}, {0.150, 0.060, 1}};
  const std::array<double, 5> curve{2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
  cmsToneCurve* const tone = cmsBuildParametricToneCurve(nullptr, 4, curve.data());
  const std::array<cmsToneCurve*, 3> tones{tone, tone, tone};
  const cmsHPROFILE profile = cmsCreateRGBProfile(&white, &primaries, tones.data());
  cmsUInt32Number size = 0;
  cmsSaveProfileToMem(profile, nullptr, &size);
  std::vector<std::uint8_t> bytes(size);
  cmsSaveProfileToMem(profile, bytes.data(), &size);
  cmsCloseProfile(profile);
  cmsFreeToneCurve(tone);
  return bytes;
}

// The quarters' colours, taken as Display P3, in sRGB: by the matrices of CSS Color 4, section 18.
std::array<Level3, 4> quarters_from_p3() {
  constexpr std::array<std::array<double, 3>, 3> kSrgbFromP3{
      {{1.2249401, -0.2249402, 0}, {-0.0420570, 1.0420571, 0}, {-0.0196376, -0.0786507, 1.0982884}}};
  std::array<Level3, 4> levels{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t row = 0; row < 3; ++row) {
      double light = 0;
      for (std::size_t k = 0; k < 3; ++k) light += kSrgbFromP3[row][k] * linear_light(kQuarters[i][k]);
      light = std::min(std::max(light, 0.0), 1.0);
      const double coded = light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
      levels[i][row] = static_cast<int>(std::lround(255 * coded));
    }
  }
  return levels;
}

constexpr int kLossy = 6;  // levels, in the middle of a rectangle of one colour at quality 95
constexpr int kRaw = 3;    // levels: matrices of four digits, and rounding

TEST_CASE("HEIC and AVIF photographs are read, told by their first bytes") {
  const TemporaryFolder folder;
  for (const auto coding : {heif_compression_HEVC, heif_compression_AV1}) {
    HeifForm form;
    form.coding = coding;
    const auto path = written_heif(folder, "a.jpg", form);
    if (!path) continue;
    const ImageSize size = photograph_size(*path);
    CHECK(size.width == kFormWidth);
    CHECK(size.height == kFormHeight);
    check_quarters(read_photograph(*path), kQuarters, kLossy);
    CHECK(read_alpha(*path).empty());
    CHECK(read_camera_note(*path).make == "Acm");
  }
}

TEST_CASE("a HEIC photograph of ten bits is read") {
  const TemporaryFolder folder;
  HeifForm form;
  form.ten_bits = true;
  const auto path = written_heif(folder, "a.heic", form);
  if (path) check_quarters(read_photograph(*path), kQuarters, kLossy);
}

TEST_CASE("the alpha of a HEIC photograph is read by itself") {
  const TemporaryFolder folder;
  HeifForm form;
  form.alpha = true;
  const auto path = written_heif(folder, "a.heic", form);
  if (!path) return;
  const std::vector<std::uint8_t> alpha = read_alpha(*path);
  REQUIRE(alpha.size() == std::size_t{kFormWidth} * kFormHeight);
  CHECK(alpha[kFormWidth / 4] > 250);
  CHECK(alpha[3 * kFormWidth / 4] < 5);
  check_quarters(read_photograph(*path), kQuarters, kLossy);
}

TEST_CASE("a HEIC photograph is turned once, although its EXIF says the same again") {
  const TemporaryFolder folder;
  HeifForm form;
  form.turned = 6;  // to be turned clockwise
  const auto path = written_heif(folder, "a.heic", form);
  if (!path) return;
  const std::array<Level3, 4> turned{kQuarters[2], kQuarters[0], kQuarters[3], kQuarters[1]};
  for (const Orientation orientation : {Orientation::exif, Orientation::as_stored}) {
    const Photograph photo = read_photograph(*path, orientation);
    CHECK(photo.width == kFormHeight);
    CHECK(photo.height == kFormWidth);
    CHECK(photograph_size(*path, orientation).width == photo.width);
    check_quarters(photo, turned, kLossy);
  }
}

TEST_CASE("HEIC colours in Display P3 become sRGB, by a profile or by the number of their primaries") {
  const TemporaryFolder folder;
  HeifForm by_profile;
  by_profile.profile = display_p3_bytes();
  HeifForm by_number;
  by_number.primaries = heif_color_primaries_SMPTE_EG_432_1;
  const auto first = written_heif(folder, "profile.heic", by_profile);
  if (!first) return;
  check_quarters(read_photograph(*first), quarters_from_p3(), kLossy + 2);
  const auto second = written_heif(folder, "number.heic", by_number);
  check_quarters(read_photograph(second.value()), quarters_from_p3(), kLossy + 2);
}

TEST_CASE("a HEIC file that claims another size than its picture has is refused") {
  const TemporaryFolder folder;
  std::string file = heif_file({});
  if (file.empty()) return skip("libheif does not encode HEIC");
  const std::size_t at = file.find("ispe");
  REQUIRE(at != std::string::npos);
  file[at + 10] = file[at + 14] = 2;  // 512 pixels
  file[at + 11] = file[at + 15] = 0;
  CHECK_THAT(refusal(folder.with_file("a.heic", file)), Catch::Contains("damaged"));
  file[at + 10] = file[at + 14] = '\x7f';
  CHECK_THAT(refusal(folder.with_file("a.heic", file)), Catch::Contains("which its"));
}

TEST_CASE("a raw photograph is developed to sRGB with the camera's white balance") {
  const TemporaryFolder folder;
  DngForm evening;
  evening.neutral = {0.45, 1, 0.7};
  evening.big_endian = true;
  for (const DngForm& form : {DngForm{}, evening}) {
    const fs::path path = folder.with_file("a.dng", dng_file(form));
    CHECK(photograph_size(path).width == kFormWidth);
    const Photograph photo = read_photograph(path);
    REQUIRE(photo.width == kFormWidth);
    REQUIRE(photo.height == kFormHeight);
    check_quarters(photo, kQuarters, kRaw);
    CHECK(read_alpha(path).empty());
    const CameraNote note = read_camera_note(path);
    CHECK(note.make == "Acme");
    CHECK(note.model == "One");
  }
}

TEST_CASE("a raw photograph is turned once, whatever is asked for") {
  const TemporaryFolder folder;
  DngForm form;
  form.orientation = 6;
  const fs::path path = folder.with_file("a.dng", dng_file(form));
  const std::array<Level3, 4> turned{kQuarters[2], kQuarters[0], kQuarters[3], kQuarters[1]};
  for (const Orientation orientation : {Orientation::exif, Orientation::as_stored}) {
    const Photograph photo = read_photograph(path, orientation);
    CHECK(photo.width == kFormHeight);
    CHECK(photograph_size(path, orientation).width == kFormHeight);
    check_quarters(photo, turned, kRaw);
  }
}

// Every file is taken or refused with its name and a reason.
void check_damage(const TemporaryFolder& folder, const std::string& name, const std::string& whole, std::size_t step) {
  const std::string start = (folder / name).string() + ": ";
  const auto check_one = [&](const std::string& bytes) {
    const std::string reason = refusal(folder.with_file(name, bytes));
    if (reason != "taken") CHECK_THAT(reason, Catch::StartsWith(start));
  };
  for (std::size_t bytes = 12; bytes < whole.size(); bytes += step) {
    INFO("cut off after " << bytes << " bytes");
    const std::string reason = refusal(folder.with_file(name, whole.substr(0, bytes)));
    CHECK_THAT(reason, Catch::StartsWith(start));
  }
  for (std::size_t at = 12; at < whole.size(); at += at < 1024 ? 1 : step) {
    constexpr std::array kMasks{0x01, 0x80, 0xff};
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ kMasks.at(at % kMasks.size()));
    check_one(changed);
  }
}

TEST_CASE("a damaged HEIC file is read or refused in one sentence, and a cut one refused") {
  const std::string whole = heif_file({});
  if (whole.empty()) return skip("libheif does not encode HEIC");
  const TemporaryFolder folder;
  check_damage(folder, "a.heic", whole, 7);
}

TEST_CASE("a damaged raw file is read or refused in one sentence, and a cut one refused") {
  const TemporaryFolder folder;
  check_damage(folder, "a.dng", dng_file({}), 397);
}

TEST_CASE("a raw file that claims more than its bytes can hold is refused before it is decoded") {
  const TemporaryFolder folder;
  std::string file = dng_file({});
  file[8 + 2 + 12 + 8 + 1] = '\x7f';      // of the width
  file[8 + 2 + 2 * 12 + 8 + 1] = '\x7f';  // of the height
  CHECK_THAT(refusal(folder.with_file("a.dng", file)), Catch::Contains("which its"));
}

TEST_CASE("forms that have no reader are refused by the form's name") {
  const TemporaryFolder folder;
  using namespace std::string_literals;
  const std::string rest = ", which this program does not read: convert it to JPEG";
  CHECK_THAT(refusal(folder.with_file("a.jxl", "\0\0\0\x0cJXL \r\n\x87\n"s)),
             Catch::EndsWith("a JPEG XL image" + rest));
  CHECK_THAT(refusal(folder.with_file("b.jxl", "\xff\x0a, and more bytes")), Catch::EndsWith("a JPEG XL image" + rest));
  CHECK_THAT(refusal(folder.with_file("a.jp2", "\0\0\0\x0cjP  \r\n\x87\n"s)),
             Catch::EndsWith("a JPEG 2000 image" + rest + " or TIFF"));
  CHECK_THAT(refusal(folder.with_file("a.cr3",
                                      "\0\0\0\x18"
                                      "ftypcrx more"s)),
             Catch::Contains("raw photograph"));
}

TEST_CASE("several threads read HEIC and raw photographs at once") {
  const TemporaryFolder folder;
  std::vector<fs::path> paths{folder.with_file("a.dng", dng_file({}))};
  if (const std::string file = heif_file({}); !file.empty()) paths.push_back(folder.with_file("a.heic", file));
  std::vector<Photograph> alone;
  for (const fs::path& path : paths) alone.push_back(read_photograph(path));
  std::atomic<int> same = 0;
  std::vector<std::thread> threads;
  constexpr int kThreads = 6, kTimes = 10;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < kTimes; ++i) {
        for (std::size_t k = 0; k < paths.size(); ++k) same += read_photograph(paths[k]).rgb == alone[k].rgb ? 1 : 0;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(same == kThreads * kTimes * static_cast<int>(paths.size()));
}

}  // namespace
}  // namespace lumatlas
