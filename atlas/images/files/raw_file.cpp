// SPDX-License-Identifier: GPL-3.0-or-later
// TIFF 6.0, section 2: directories. Adobe DNG 1.6: PhotometricInterpretation of what a sensor saw.
#include <libraw/libraw.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "atlas/images/files/picture_file.h"
#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

using DevelopedRaw = std::unique_ptr<libraw_processed_image_t, decltype(&LibRaw::dcraw_clear_mem)>;

// LibRaw's constructor sets up data that all threads share.
std::unique_ptr<LibRaw> new_raw_decoder() {
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  return std::make_unique<LibRaw>();
}

void require_raw(int status, const fs::path& path) {
  if (status == LIBRAW_SUCCESS) return;
  const std::string start = path.string() + ": ";
  if (status == LIBRAW_FILE_UNSUPPORTED || status == LIBRAW_NOT_IMPLEMENTED) {
    throw InputError(start + "is a raw photograph that LibRaw " + LibRaw::version() +
                     " cannot read: convert it to JPEG");
  }
  if (status == LIBRAW_UNSUFFICIENT_MEMORY) throw InputError(start + "LibRaw has no memory for this raw photograph");
  throw InputError(start + "is a raw photograph that is damaged or cut off (" + LibRaw::strerror(status) +
                   "); copy it again");
}

// Returns the angle of degrees, minutes and seconds.
double degrees_of(const float (&parts)[3], bool is_negative) {
  const double degrees =
      static_cast<double>(parts[0]) + static_cast<double>(parts[1]) / 60 + static_cast<double>(parts[2]) / 3600;
  return is_negative ? -degrees : degrees;
}

std::optional<GpsPosition> place_of(const libraw_gps_info_t& gps) {
  if (gps.gpsparsed == 0) return std::nullopt;
  GpsPosition place{degrees_of(gps.latitude, gps.latref == 'S'), degrees_of(gps.longitude, gps.longref == 'W'),
                    static_cast<double>(gps.altref == 1 ? -gps.altitude : gps.altitude)};
  const bool is_on_earth = std::abs(place.latitude_deg) <= 90 && std::abs(place.longitude_deg) <= 180;
  const bool is_known = place.latitude_deg != 0 || place.longitude_deg != 0;
  if (!is_on_earth || !is_known) return std::nullopt;
  return place;
}

class RawFile : public PictureFile {
 public:
  explicit RawFile(const fs::path& path) : path_(path) {
    open();
    require_raw(decoder_->adjust_sizes_info_only(), path_);
    const libraw_image_sizes_t& sizes = decoder_->imgdata.sizes;
    size_ = {sizes.iwidth, sizes.iheight};
  }

  [[nodiscard]] ImageExtent size() const override { return size_; }
  [[nodiscard]] std::uint64_t decoder_bytes() const override {
    const libraw_image_sizes_t& sizes = decoder_->imgdata.sizes;
    constexpr std::uint64_t kOfSensor = 2, kOfPicture = 8 + 3;
    return kOfSensor * sizes.raw_width * sizes.raw_height + kOfPicture * size_.width * size_.height;
  }
  [[nodiscard]] ExifNote exif() const override {
    const libraw_data_t& data = decoder_->imgdata;
    ExifNote note;
    note.make = data.idata.make;
    note.model = data.idata.model;
    note.focal_length_mm = data.other.focal_len > 0 ? static_cast<double>(data.other.focal_len) : 0;
    note.focal_length_35mm = std::max(0.0, static_cast<double>(data.lens.FocalLengthIn35mmFormat));
    note.gps = place_of(data.other.parsed_gps);
    return note;
  }
  [[nodiscard]] PicturePixels decode() override;

 private:
  static void note_damage(void* is_damaged, const char* /*file*/, int /*offset*/) {
    *static_cast<bool*>(is_damaged) = true;
  }
  static void set_options(libraw_output_params_t& options);
  void open();

  fs::path path_;
  bool is_damaged_ = false;
  std::unique_ptr<LibRaw> decoder_;
  ImageExtent size_{};
};

// The brightest value, the brightness and the white balance are the camera's, never the picture's.
void RawFile::set_options(libraw_output_params_t& options) {
  constexpr int kSrgb = 1;
  options.output_color = kSrgb;
  options.gamm[0] = 1 / 2.4;
  options.gamm[1] = 12.92;
  options.output_bps = 8;
  options.use_camera_wb = 1;
  options.no_auto_bright = 1;
  options.adjust_maximum_thr = 0;
}

void RawFile::open() {
  decoder_ = new_raw_decoder();
  decoder_->set_dataerror_handler(note_damage, &is_damaged_);
  set_options(decoder_->imgdata.params);
  require_raw(decoder_->open_file(path_.c_str()), path_);
}

PicturePixels RawFile::decode() {
  open();  // again: what has told its size does not unpack
  require_raw(decoder_->unpack(), path_);
  require_raw(decoder_->dcraw_process(), path_);
  int status = LIBRAW_SUCCESS;
  const DevelopedRaw image(decoder_->dcraw_make_mem_image(&status), &LibRaw::dcraw_clear_mem);
  require_raw(status, path_);
  if (is_damaged_) require_raw(LIBRAW_DATA_ERROR, path_);
  if (!image || image->type != LIBRAW_IMAGE_BITMAP || image->bits != 8 || (image->colors != 1 && image->colors != 3)) {
    require_raw(LIBRAW_FILE_UNSUPPORTED, path_);
  }
  PicturePixels pixels{{image->width, image->height}, {}, {}, {}};
  const std::size_t count = std::size_t{image->width} * image->height;
  if (image->colors == 3) {
    pixels.rgb.assign(image->data, image->data + 3 * count);
  } else {
    for (std::size_t i = 0; i < count; ++i) pixels.rgb.insert(pixels.rgb.end(), 3, image->data[i]);
  }
  return pixels;
}

// A TIFF file's numbers, wherever they lie; 0 where there are none.
class TiffNumbers {
 public:
  TiffNumbers(std::istream& file, bool is_big_endian) : file_(file), is_big_endian_(is_big_endian) {}

  [[nodiscard]] std::uint32_t number(std::uint64_t at, int bytes) const {
    std::array<char, 4> read{};
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(at));
    if (!file_.read(read.data(), bytes)) return 0;
    std::uint32_t value = 0;
    for (int i = 0; i < bytes; ++i) {
      value = value << 8U | static_cast<unsigned char>(read.at(is_big_endian_ ? i : bytes - 1 - i));
    }
    return value;
  }

 private:
  std::istream& file_;
  bool is_big_endian_;
};

// Returns whether a directory, or one of those below it, holds the values of a sensor.
bool holds_sensor(const TiffNumbers& tiff, std::uint64_t directory, bool look_below) {
  constexpr std::uint32_t kPhotometric = 262, kBelow = 330, kColorFilters = 32803, kLinearRaw = 34892;
  constexpr std::uint32_t kMostBelow = 16, kWordsInEntry = 1;
  const std::uint32_t entries = tiff.number(directory, 2);
  for (std::uint32_t i = 0; i < entries; ++i) {
    const std::uint64_t entry = directory + 2 + std::uint64_t{12} * i;
    const std::uint32_t tag = tiff.number(entry, 2), count = tiff.number(entry + 4, 4);
    if (tag == kPhotometric) {
      const std::uint32_t meaning = tiff.number(entry + 8, 2);
      if (meaning == kColorFilters || meaning == kLinearRaw) return true;
    }
    if (tag != kBelow || !look_below) continue;
    const std::uint64_t list = count <= kWordsInEntry ? entry + 8 : tiff.number(entry + 8, 4);
    for (std::uint32_t k = 0; k < std::min(count, kMostBelow); ++k) {
      if (holds_sensor(tiff, tiff.number(list + std::uint64_t{4} * k, 4), false)) return true;
    }
  }
  return false;
}

}  // namespace

std::unique_ptr<PictureFile> open_raw(const fs::path& path) {
  return std::make_unique<RawFile>(path);
}

bool is_raw(std::string_view head, std::istream& file) {
  using namespace std::string_view_literals;
  constexpr std::array kSignatures{"FUJIFILM"sv, "IIRO"sv,  "IIRS"sv, "MMOR"sv,
                                   "IIU\0"sv,    "\0MRM"sv, "FOVb"sv, "II\x1a\0\0\0HEAPCC"sv};
  const auto begins = [&](std::string_view signature) { return head.starts_with(signature); };
  if (std::any_of(kSignatures.begin(), kSignatures.end(), begins)) return true;
  if (head.size() >= 12 && head.substr(4, 8) == "ftypcrx ") return true;  // CR3
  if (!begins("II*\0"sv) && !begins("MM\0*"sv)) return false;
  if (head.size() >= 10 && head.substr(8, 2) == "CR") return true;  // CR2
  const TiffNumbers tiff(file, begins("MM"));
  return holds_sensor(tiff, tiff.number(4, 4), true);
}

}  // namespace lumatlas
