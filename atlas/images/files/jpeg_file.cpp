// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/images/files/jpeg_file.h"

// Each needs what stands before it.
// clang-format off
#include <cstdio>
#include <jpeglib.h>
#include <jerror.h>
// clang-format on

#include <csetjmp>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <string>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

// A progressive file may repeat scans of a few bytes without end, each of which takes a pass over the picture.
// libjpeg's own limit for its tests; encoders write about ten.
constexpr int kMostScans = 500;

// Cameras pad coded data to a length that suits them; 16 bytes is the most that such a length needs. In 2440
// trials in which photographs were garbled on purpose, whatever was left over had 23 bytes or more.
constexpr int kMostPadding = 16;  // bytes

// libjpeg calls back where it fails; C code is left by longjmp, so that nothing between here and there may own
// anything.
struct Decoder {
  jpeg_decompress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg_progress_mgr progress{};
  std::jmp_buf failed{};
  char reason[JMSG_LENGTH_MAX] = "";  // why it failed

  Decoder();
  ~Decoder() { jpeg_destroy_decompress(&jpeg); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;
};

[[noreturn]] void give_up(j_common_ptr jpeg) {
  auto* const decoder = static_cast<Decoder*>(jpeg->client_data);
  decoder->errors.format_message(jpeg, decoder->reason);
  std::longjmp(decoder->failed, 1);
}

// The warnings of libjpeg that mean that pixels are wrong. The others are about headers (an unknown version, a colour
// profile, the parameters of a sequential scan), or about an encoder that is merely unusual, and all pixels are there.
bool tells_of_damage(const Decoder& decoder) {
  switch (decoder.errors.msg_code) {
    case JWRN_HIT_MARKER:
    case JWRN_HUFF_BAD_CODE:
    case JWRN_ARITH_BAD_CODE:
    case JWRN_JPEG_EOF:
    case JWRN_MUST_RESYNC:
      return true;
    case JWRN_EXTRANEOUS_DATA: {
      const bool among_headers = decoder.jpeg.input_scan_number == 0;
      return !among_headers && decoder.errors.msg_parm.i[0] > kMostPadding;
    }
    default:
      return false;
  }
}

void take_message(j_common_ptr jpeg, int level) {
  const bool is_warning = level < 0;
  if (is_warning && tells_of_damage(*static_cast<const Decoder*>(jpeg->client_data))) give_up(jpeg);
}

void limit_scans(j_common_ptr jpeg) {
  auto* const decoder = static_cast<Decoder*>(jpeg->client_data);
  if (decoder->jpeg.input_scan_number <= kMostScans) return;
  (void)std::snprintf(decoder->reason, sizeof decoder->reason, "more than %d scans", kMostScans);
  std::longjmp(decoder->failed, 1);
}

Decoder::Decoder() {
  jpeg.err = jpeg_std_error(&errors);
  errors.error_exit = give_up;
  errors.emit_message = take_message;
  jpeg.client_data = this;
  if (setjmp(failed) != 0) throw InputError(std::string("libjpeg cannot start: ") + reason);
  jpeg_create_decompress(&jpeg);
  progress.progress_monitor = limit_scans;
  jpeg.progress = &progress;
}

// The functions below say false where the decoder gave up.

bool read_header(Decoder& decoder, std::span<const std::uint8_t> bytes) {
  if (setjmp(decoder.failed) != 0) return false;
  jpeg_mem_src(&decoder.jpeg, bytes.data(), bytes.size());
  constexpr int kProfileMarker = JPEG_APP0 + 2;
  constexpr unsigned int kLongestMarker = 0xffff;
  jpeg_save_markers(&decoder.jpeg, kProfileMarker, kLongestMarker);
  jpeg_read_header(&decoder.jpeg, TRUE);
  return true;
}

// Sets `profile` to memory of malloc(), which the caller frees; null: the file has no profile.
bool read_profile(Decoder& decoder, JOCTET** profile, unsigned int* size) {
  if (setjmp(decoder.failed) != 0) return false;
  if (!jpeg_read_icc_profile(&decoder.jpeg, profile, size)) *profile = nullptr;
  return true;
}

bool is_cmyk(const Decoder& decoder) {
  return decoder.jpeg.jpeg_color_space == JCS_CMYK || decoder.jpeg.jpeg_color_space == JCS_YCCK;
}

// Without an ink's profile: what is left of white light by each ink and black. The file holds 255 for no ink.
void rgb_from_cmyk(std::span<const std::uint8_t> cmyk, std::uint8_t* rgb) {
  for (std::size_t at = 0; at < cmyk.size(); at += 4) {
    const float black = static_cast<float>(cmyk[at + 3]) / 255.0f;
    for (std::size_t ink = 0; ink < 3; ++ink) {
      *rgb++ = static_cast<std::uint8_t>(static_cast<float>(cmyk[at + ink]) / 255.0f * black * 255.0f + 0.5f);
    }
  }
}

bool start(Decoder& decoder) {
  if (setjmp(decoder.failed) != 0) return false;
  decoder.jpeg.out_color_space = is_cmyk(decoder) ? JCS_CMYK : JCS_RGB;
  jpeg_start_decompress(&decoder.jpeg);
  return true;
}

// Reads the next rows. `inks` is one row of CMYK, or empty for a picture of another kind.
bool read_rows(Decoder& decoder, std::span<std::uint8_t> inks, std::uint32_t rows, std::uint8_t* rgb) {
  if (setjmp(decoder.failed) != 0) return false;
  jpeg_decompress_struct& jpeg = decoder.jpeg;
  for (std::uint32_t i = 0; i < rows; ++i) {
    std::uint8_t* const row = rgb + std::size_t{3} * jpeg.output_width * i;
    JSAMPROW to = inks.empty() ? row : inks.data();
    jpeg_read_scanlines(&jpeg, &to, 1);
    if (!inks.empty()) rgb_from_cmyk(inks, row);
  }
  return true;
}

// Goes on to the end marker, and so tells of what is left over.
bool finish(Decoder& decoder) {
  if (setjmp(decoder.failed) != 0) return false;
  jpeg_finish_decompress(&decoder.jpeg);
  return true;
}

std::vector<std::uint8_t> profile_of(Decoder& decoder) {
  JOCTET* found = nullptr;
  unsigned int size = 0;
  const bool is_read = read_profile(decoder, &found, &size);
  const std::unique_ptr<JOCTET, decltype(&std::free)> bytes(found, &std::free);
  return is_read && bytes ? std::vector<std::uint8_t>(found, found + size) : std::vector<std::uint8_t>();
}

InputError damaged(const std::filesystem::path& path, const Decoder& decoder) {
  return InputError(path.string() + ": is damaged or cut off (" + decoder.reason + "); copy it again");
}

void read_checked_header(Decoder& decoder, std::span<const std::uint8_t> bytes, const std::filesystem::path& path,
                         std::uint32_t width, std::uint32_t height) {
  if (!read_header(decoder, bytes)) throw damaged(path, decoder);
  const jpeg_decompress_struct& jpeg = decoder.jpeg;
  if (jpeg.image_width != width || jpeg.image_height != height) {
    throw InputError(path.string() + ": its header says " + size_text(width, height) + " pixels, its decoder finds " +
                     size_text(jpeg.image_width, jpeg.image_height) + ": it is damaged");
  }
  if (jpeg.jpeg_color_space == JCS_UNKNOWN) {
    throw InputError(path.string() + ": has " + std::to_string(jpeg.num_components) +
                     " colour components, must be grey, RGB, YCbCr, CMYK or YCCK");
  }
}

// Calls use(first_row, rows, read) for each band of at most `rows_at_once` rows, from the top; read(rgb) decodes the
// band.
template <typename Use>
void decode_rows(Decoder& decoder, const std::filesystem::path& path, std::uint32_t rows_at_once, const Use& use) {
  if (!start(decoder)) throw damaged(path, decoder);
  const std::uint32_t width = decoder.jpeg.output_width, height = decoder.jpeg.output_height;
  std::vector<std::uint8_t> inks(is_cmyk(decoder) ? std::size_t{4} * width : 0);
  for (std::uint32_t row = 0; row < height; row += rows_at_once) {
    const std::uint32_t rows = std::min(rows_at_once, height - row);
    use(row, rows, [&](std::uint8_t* rgb) {
      if (!read_rows(decoder, inks, rows, rgb)) throw damaged(path, decoder);
    });
  }
  if (!finish(decoder)) throw damaged(path, decoder);
}

}  // namespace

JpegPixels decode_jpeg(std::span<const std::uint8_t> bytes, const std::filesystem::path& path, std::uint32_t width,
                       std::uint32_t height) {
  Decoder decoder;
  read_checked_header(decoder, bytes, path, width, height);
  JpegPixels pixels{std::vector<std::uint8_t>(std::size_t{3} * width * height), profile_of(decoder)};
  decode_rows(decoder, path, height, [&](std::uint32_t, std::uint32_t, const auto& read) { read(pixels.rgb.data()); });
  return pixels;
}

bool decode_jpeg_rows(std::span<const std::uint8_t> bytes, const std::filesystem::path& path, std::uint32_t width,
                      std::uint32_t height, const PixelRows& use) {
  constexpr std::uint32_t kRows = 64;
  Decoder decoder;
  read_checked_header(decoder, bytes, path, width, height);
  if (!profile_of(decoder).empty()) return false;
  std::vector<std::uint8_t> band;
  decode_rows(decoder, path, kRows, [&](std::uint32_t row, std::uint32_t rows, const auto& read) {
    band.resize(std::size_t{3} * width * rows);
    read(band.data());
    use(row, band);
  });
  return true;
}

}  // namespace lumatlas
