// SPDX-License-Identifier: GPL-3.0-or-later
// ISO/IEC 23008-12 (HEIF), annex A.2.1: the block of EXIF.
#include <libheif/heif.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "atlas/images/files/color_profile.h"
#include "atlas/images/files/picture_file.h"
#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

using HeifContext = std::unique_ptr<heif_context, decltype(&heif_context_free)>;
using HeifHandle = std::unique_ptr<heif_image_handle, decltype(&heif_image_handle_release)>;
using HeifImage = std::unique_ptr<heif_image, decltype(&heif_image_release)>;
using HeifOptions = std::unique_ptr<heif_decoding_options, decltype(&heif_decoding_options_free)>;
using HeifNclx = std::unique_ptr<heif_color_profile_nclx, decltype(&heif_nclx_color_profile_free)>;

constexpr std::size_t kMostHeifBlock = 8 << 20;  // for a profile or EXIF

void require_heif(const heif_error& error, const fs::path& path) {
  if (error.code == heif_error_Ok) return;
  const std::string reason = error.message ? " (" + std::string(error.message) + ")" : "";
  const bool no_decoder = error.subcode == heif_suberror_Unsupported_codec;
  throw InputError(path.string() +
                   (no_decoder ? ": libheif is installed without a decoder for this HEIC or AVIF image"
                               : ": is damaged, cut off or no HEIC or AVIF image that libheif reads") +
                   reason + (no_decoder ? "; install one, or convert it to JPEG" : ""));
}

// libheif's list of decoders is filled by the first call, which another thread must not see half done.
HeifContext new_heif_context() {
  static const bool ready = heif_init(nullptr).code == heif_error_Ok;
  (void)ready;
  HeifContext context(heif_context_alloc(), heif_context_free);
  if (context) heif_context_set_max_decoding_threads(context.get(), 0);  // callers decide about parallelism
  return context;
}

HeifHandle primary_heif_image(heif_context* context, const fs::path& path) {
  heif_image_handle* handle = nullptr;
  require_heif(heif_context_get_primary_image_handle(context, &handle), path);
  return {handle, heif_image_handle_release};
}

// Colours that are given by number. Empty for those of sRGB and for unspecified ones.
std::vector<std::uint8_t> numbered_heif_profile(const heif_image_handle* handle) {
  heif_color_profile_nclx* found = nullptr;
  if (heif_image_handle_get_nclx_color_profile(handle, &found).code != heif_error_Ok || !found) return {};
  const HeifNclx nclx(found, heif_nclx_color_profile_free);
  switch (nclx->color_primaries) {
    case heif_color_primaries_ITU_R_BT_2020_2_and_2100_0:
    case heif_color_primaries_SMPTE_RP_431_2:
    case heif_color_primaries_SMPTE_EG_432_1:
      break;
    default:
      return {};
  }
  return profile_of({{nclx->color_primary_red_x, nclx->color_primary_red_y},
                     {nclx->color_primary_green_x, nclx->color_primary_green_y},
                     {nclx->color_primary_blue_x, nclx->color_primary_blue_y},
                     {nclx->color_primary_white_x, nclx->color_primary_white_y}});
}

std::vector<std::uint8_t> heif_profile(const heif_image_handle* handle) {
  if (heif_image_handle_get_color_profile_type(handle) == heif_color_profile_type_nclx)
    return numbered_heif_profile(handle);
  const std::size_t bytes = heif_image_handle_get_raw_color_profile_size(handle);
  if (bytes == 0 || bytes > kMostHeifBlock) return {};
  std::vector<std::uint8_t> profile(bytes);
  const heif_error error = heif_image_handle_get_raw_color_profile(handle, profile.data());
  return error.code == heif_error_Ok ? profile : std::vector<std::uint8_t>();
}

// The block begins with the distance to the TIFF structure, from the byte after that number on.
ExifNote heif_exif(const heif_image_handle* handle) {
  heif_item_id id = 0;
  if (heif_image_handle_get_list_of_metadata_block_IDs(handle, "Exif", &id, 1) != 1) return {};
  const std::size_t bytes = heif_image_handle_get_metadata_size(handle, id);
  if (bytes < 4 || bytes > kMostHeifBlock) return {};
  std::string block(bytes, '\0');
  if (heif_image_handle_get_metadata(handle, id, block.data()).code != heif_error_Ok) return {};
  std::size_t before = 0;
  for (std::size_t i = 0; i < 4; ++i) before = before << 8U | static_cast<unsigned char>(block[i]);
  if (before > bytes - 4) return {};
  std::string_view tiff = std::string_view(block).substr(4 + before);
  constexpr std::string_view kSegment("Exif\0\0", 6);  // some programs count from before it
  if (tiff.starts_with(kSegment)) tiff.remove_prefix(kSegment.size());
  return read_exif(tiff);
}

class HeifFile : public PictureFile {
 public:
  explicit HeifFile(const fs::path& path) : path_(path) {
    if (!context_) throw InputError(path_.string() + ": libheif has no memory for it");
    require_heif(heif_context_read_from_file(context_.get(), path_.c_str(), nullptr), path_);
    handle_ = primary_heif_image(context_.get(), path_);
  }

  [[nodiscard]] ImageExtent size() const override {
    const int width = heif_image_handle_get_width(handle_.get()), height = heif_image_handle_get_height(handle_.get());
    return {static_cast<std::uint32_t>(std::max(width, 0)), static_cast<std::uint32_t>(std::max(height, 0))};
  }
  [[nodiscard]] std::uint64_t decoder_bytes() const override {
    const auto side = [](int pixels) { return static_cast<std::uint64_t>(std::max(pixels, 0)); };
    return 4 * side(heif_image_handle_get_ispe_width(handle_.get())) *
           side(heif_image_handle_get_ispe_height(handle_.get()));
  }
  [[nodiscard]] ExifNote exif() const override { return heif_exif(handle_.get()); }
  [[nodiscard]] PicturePixels decode() override;

 private:
  fs::path path_;
  HeifContext context_ = new_heif_context();
  HeifHandle handle_{nullptr, heif_image_handle_release};
};

HeifImage decoded_heif(const heif_image_handle* handle, bool with_alpha, const fs::path& path) {
  const HeifOptions options(heif_decoding_options_alloc(), heif_decoding_options_free);
  options->convert_hdr_to_8bit = 1;
  options->strict_decoding = 1;
  heif_image* image = nullptr;
  require_heif(
      heif_decode_image(handle, &image, heif_colorspace_RGB,
                        with_alpha ? heif_chroma_interleaved_RGBA : heif_chroma_interleaved_RGB, options.get()),
      path);
  return {image, heif_image_release};
}

PicturePixels HeifFile::decode() {
  const bool with_alpha = heif_image_handle_has_alpha_channel(handle_.get()) != 0;
  const HeifImage image = decoded_heif(handle_.get(), with_alpha, path_);
  const int width = heif_image_get_width(image.get(), heif_channel_interleaved);
  const int height = heif_image_get_height(image.get(), heif_channel_interleaved);
  int stride = 0;
  const std::uint8_t* row = heif_image_get_plane_readonly(image.get(), heif_channel_interleaved, &stride);
  if (!row || width < 1 || height < 1) throw InputError(path_.string() + ": libheif finds no pixels in it");
  PicturePixels pixels{{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)}, {}, {}, {}};
  const std::size_t samples = with_alpha ? 4 : 3, count = std::size_t{pixels.size.width} * pixels.size.height;
  pixels.rgb.reserve(3 * count);
  if (with_alpha) pixels.alpha.reserve(count);
  for (int y = 0; y < height; ++y, row += stride) {
    for (std::size_t x = 0; x < pixels.size.width; ++x) {
      const std::uint8_t* const from = row + samples * x;
      pixels.rgb.insert(pixels.rgb.end(), from, from + 3);
      if (with_alpha) pixels.alpha.push_back(from[3]);
    }
  }
  pixels.profile = heif_profile(handle_.get());
  return pixels;
}

}  // namespace

std::unique_ptr<PictureFile> open_heif(const fs::path& path) {
  return std::make_unique<HeifFile>(path);
}

}  // namespace lumatlas
