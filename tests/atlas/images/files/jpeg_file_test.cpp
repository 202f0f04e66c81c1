// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/images/files/jpeg_file.h"

#include <OpenImageIO/imageio.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

// Each needs what stands before it.
// clang-format off
#include <cstdio>
#include <jpeglib.h>
// clang-format on

#include "atlas/images/photograph.h"
#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kWidth = 136, kHeight = 88;  // no multiples of 16: the last blocks are cut

struct Coding {
  J_COLOR_SPACE color_space = JCS_RGB;
  int components = 3;
  bool progressive = false;
  int restart_rows = 0;      // rows of blocks between restart markers; 0: none
  bool full_chroma = false;  // 4:4:4
};

// Every sample differs from its neighbours, so that no block is flat.
std::vector<std::uint8_t> textured_samples(int components) {
  std::vector<std::uint8_t> samples;
  std::uint32_t state = 1;
  for (std::uint32_t at = 0; at < kWidth * kHeight * static_cast<std::uint32_t>(components); ++at) {
    state = state * 1664525u + 1013904223u;
    samples.push_back(static_cast<std::uint8_t>(at / 97 % 160 + (state >> 26)));
  }
  return samples;
}

// Writes by libjpeg, because OpenImageIO writes neither CMYK nor restart markers.
std::string jpeg_file(const Coding& coding) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &bytes, &size);
  jpeg.image_width = kWidth;
  jpeg.image_height = kHeight;
  jpeg.input_components = coding.components;
  jpeg.in_color_space = coding.color_space;
  jpeg_set_defaults(&jpeg);
  if (coding.full_chroma) jpeg.comp_info[0].h_samp_factor = jpeg.comp_info[0].v_samp_factor = 1;
  jpeg.restart_in_rows = coding.restart_rows;
  if (coding.progressive) jpeg_simple_progression(&jpeg);
  jpeg_start_compress(&jpeg, TRUE);
  std::vector<std::uint8_t> samples = textured_samples(coding.components);
  while (jpeg.next_scanline < kHeight) {
    JSAMPROW row = samples.data() + std::size_t{kWidth} * coding.components * jpeg.next_scanline;
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  std::string file(reinterpret_cast<const char*>(bytes), size);
  jpeg_destroy_compress(&jpeg);
  free(bytes);  // libjpeg's
  return file;
}

std::vector<std::uint8_t> decoded(const std::string& file) {
  return decode_jpeg(std::span(reinterpret_cast<const std::uint8_t*>(file.data()), file.size()), "a.jpg", kWidth,
                     kHeight)
      .rgb;
}

std::vector<std::uint8_t> decoded_by_openimageio(const fs::path& path) {
  const auto input = OIIO::ImageInput::open(path.string());
  REQUIRE(input);
  const auto channels = static_cast<std::size_t>(input->spec().nchannels);
  std::vector<std::uint8_t> samples(std::size_t{kWidth} * kHeight * channels);
  REQUIRE(input->read_image(0, 0, 0, -1, OIIO::TypeDesc::UINT8, samples.data()));
  if (channels == 3) return samples;
  std::vector<std::uint8_t> rgb;
  for (const std::uint8_t grey : samples) rgb.insert(rgb.end(), 3, grey);
  return rgb;
}

TEST_CASE("the pixels of a JPEG are those that OpenImageIO reads") {
  const TemporaryFolder folder;
  const Coding coding = GENERATE(Coding{}, Coding{JCS_GRAYSCALE, 1}, Coding{JCS_CMYK, 4}, Coding{JCS_RGB, 3, true},
                                 Coding{JCS_RGB, 3, false, 1}, Coding{JCS_RGB, 3, false, 0, true});
  CAPTURE(coding.color_space, coding.progressive, coding.restart_rows, coding.full_chroma);
  const std::string file = jpeg_file(coding);
  CHECK(decoded(file) == decoded_by_openimageio(folder.with_file("a.jpg", file)));
}

TEST_CASE("a JPEG that is garbled in the middle is refused") {
  const bool progressive = GENERATE(false, true);
  const int restart_rows = GENERATE(0, 1);
  std::string file = jpeg_file({.progressive = progressive, .restart_rows = restart_rows});
  CAPTURE(progressive, restart_rows, file.size());
  const std::size_t middle = file.size() / 2;
  SECTION("by other bytes") {
    file.replace(middle, 60, std::string(60, '\x5a'));
  }
  SECTION("by a gap") {
    file.erase(middle, 200);
  }
  SECTION("by bytes that are there twice") {
    file.insert(middle, file.substr(middle - 60, 60));
  }
  CHECK_THROWS_WITH(decoded(file),
                    Catch::StartsWith("a.jpg: is damaged or cut off (") && Catch::EndsWith("); copy it again"));
  const TemporaryFolder folder;
  CHECK_THROWS_AS(read_photograph(folder.with_file("a.jpg", file)), InputError);
}

TEST_CASE("a JPEG that is cut off is refused, also where an end marker was put behind the cut") {
  const bool progressive = GENERATE(false, true);
  const std::string file = jpeg_file({.progressive = progressive});
  CHECK_THROWS_AS(decoded(file.substr(0, file.size() / 2)), InputError);
  CHECK_THROWS_WITH(decoded(file.substr(0, file.size() / 2) + "\xff\xd9"),
                    "a.jpg: is damaged or cut off (Corrupt JPEG data: premature end of data segment); copy it again");
}

TEST_CASE("a few bytes of padding before a JPEG's end marker are a camera's habit, more of them are damage") {
  const std::string file = jpeg_file({});
  const std::string data = file.substr(0, file.size() - 2);
  CHECK(decoded(data + std::string(16, '\0') + "\xff\xd9") == decoded(file));
  // The decoder holds up to eight bytes that it does not count.
  CHECK_THROWS_WITH(decoded(data + std::string(17 + 8, '\0') + "\xff\xd9"),
                    Catch::Contains("(Corrupt JPEG data: ") &&
                        Catch::Contains(" extraneous bytes before marker 0xd9); copy it again"));
}

TEST_CASE("what lies between a JPEG's headers says nothing about its pixels") {
  const std::string file = jpeg_file({});
  const std::size_t tables = file.find("\xff\xdb");
  CHECK(decoded(file.substr(0, tables) + std::string(100, '\0') + file.substr(tables)) == decoded(file));
}

TEST_CASE("a progressive JPEG with more scans than any encoder writes is refused") {
  const std::string file = jpeg_file({.progressive = true});
  // The first scan, which holds the means of the blocks: it may come again, and changes nothing.
  const std::size_t begin = file.find("\xff\xda"), end = file.find("\xff\xc4", begin);
  const std::string scan = file.substr(begin, end - begin);
  const auto with_repeats = [&](int times) {
    std::string repeated = file;
    for (int time = 0; time < times; ++time) repeated.insert(end, scan);
    return repeated;
  };
  CHECK(decoded(with_repeats(400)) == decoded(file));
  CHECK_THROWS_WITH(decoded(with_repeats(500)), "a.jpg: is damaged or cut off (more than 500 scans); copy it again");
}

TEST_CASE("a JPEG of another size than its caller found is refused") {
  const std::string file = jpeg_file({});
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(file.data()), file.size());
  CHECK_THROWS_WITH(decode_jpeg(bytes, "a.jpg", kWidth, kHeight + 1),
                    "a.jpg: its header says 136x89 pixels, its decoder finds 136x88: it is damaged");
}

}  // namespace
}  // namespace lumatlas
