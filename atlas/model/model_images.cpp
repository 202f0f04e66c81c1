// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/model_images.h"

#include <algorithm>
#include <span>

#include "atlas/images/files/grey_png.h"
#include "atlas/images/pixel_memory.h"
#include "atlas/images/scaled_view.h"

namespace lumatlas {

namespace {

// Side of the blocks that JPEG transforms. If a block holds a pixel that is used, its other pixels must not be black,
// or their edge would ring into that pixel.
constexpr std::uint32_t kMaskBlock = 8;

void grow_to_blocks(std::vector<std::uint8_t>& mask, std::uint32_t width, std::uint32_t height) {
  const std::uint32_t columns = (width + kMaskBlock - 1) / kMaskBlock, rows = (height + kMaskBlock - 1) / kMaskBlock;
  std::vector<std::uint8_t> blocks(std::size_t{columns} * rows, 0);
  const auto block_of = [&](std::size_t pixel) -> std::uint8_t& {
    return blocks[pixel / width / kMaskBlock * columns + pixel % width / kMaskBlock];
  };
  for (std::size_t pixel = 0; pixel < mask.size(); ++pixel) block_of(pixel) |= mask[pixel];
  for (std::size_t pixel = 0; pixel < mask.size(); ++pixel) mask[pixel] = block_of(pixel);
}

// Black where no tile is resident.
Photograph resident_part(const Snapshot& snapshot, ViewSlot slot, ImageFormat format) {
  const StoredView& view = *snapshot.views[slot];
  Photograph part = view.photograph->whole();
  if (snapshot.tiles.whole_views()) return part;
  std::vector<std::uint8_t> resident = snapshot.tiles.resident_pixels(slot, view.camera);
  if (format != ImageFormat::png) grow_to_blocks(resident, view.camera.width, view.camera.height);
  for (std::size_t pixel = 0; pixel < resident.size(); ++pixel) {
    if (!resident[pixel]) std::fill_n(&part.rgb[3 * pixel], 3, 0);
  }
  return part;
}

Photograph grey_image(const Camera& camera, std::span<const std::uint8_t> values) {
  Photograph image;
  image.width = camera.width;
  image.height = camera.height;
  image.rgb.reserve(3 * values.size());
  for (const std::uint8_t value : values) image.rgb.insert(image.rgb.end(), 3, value);
  return image;
}

}  // namespace

std::string numbered_image(std::size_t view) {
  std::string number = std::to_string(view);
  number.insert(0, number.size() < 5 ? 5 - number.size() : 0, '0');
  return std::string(kImageFolder) + "/" + number;
}

std::vector<ModelImage> images_of(const Snapshot& snapshot, const ImageCoding& photographs, ViewSlot first,
                                  bool packed) {
  constexpr ImageCoding kSmall{ImageFormat::jpeg, 80};
  std::vector<ModelImage> images;
  std::size_t number = 0;
  for (ViewSlot slot{0}; slot < snapshot.views.size(); ++slot) {
    if (!snapshot.views[slot]) continue;
    const StoredView& view = *snapshot.views[slot];
    const std::string name = numbered_image(number++);
    images.push_back({ModelImageKind::photograph, slot, {name, ending(photographs.format)}, photographs});
    if (!packed && view.photograph->has_lens_mask()) {
      images.push_back({ModelImageKind::lens_mask, slot, {name + "-lens", ".png"}, {}});
    }
    if (!packed && !view.mask->trust.empty()) {
      images.push_back({ModelImageKind::trust_mask, slot, {name + "-trust", ".png"}, {}});
    }
    images.push_back({ModelImageKind::mask, slot, {name + "-mask", ".png"}, {}});
    images.push_back({ModelImageKind::thumbnail, slot, {name + "-small", ".jpg"}, kSmall});
  }
  if (number > 0) {
    images.push_back({ModelImageKind::poster, first, {std::string(kImageFolder) + "/poster", ".jpg"}, kSmall});
  }
  return images;
}

ModelFileName texture_name(const ImageCoding& coding) {
  return {std::string(kImageFolder) + "/texture", ending(coding.format)};
}

namespace {

std::vector<std::uint8_t> mask_file(const StoredView& view, PngEffort effort) {
  std::vector<std::uint8_t> grey(view.mask->validity.size());
  for (std::size_t pixel = 0; pixel < grey.size(); ++pixel) {
    grey[pixel] = grey_of_mask(view.mask->validity[pixel], view.mask->at_rim(pixel));
  }
  return grey_png(grey, view.camera.width, view.camera.height, effort);
}

std::vector<std::uint8_t> small_file(const Snapshot& snapshot, ViewSlot slot, std::uint32_t longest_px,
                                     const ImageCoding& coding) {
  const StoredView& view = *snapshot.views[slot];
  const TileTable& tiles = snapshot.tiles;
  if (tiles.whole_views()) return encode_image(small_picture(view, longest_px), coding);
  std::vector<std::uint8_t> there;
  for (std::uint32_t tile = tiles.first_tile[slot]; tile < tiles.first_tile[slot + 1]; ++tile) {
    there.push_back(tiles.places[tile] == TilePlace::none ? 0 : 1);
  }
  return encode_image(small_picture(view, longest_px, there, tiles.options.tile_px), coding);
}

}  // namespace

std::vector<std::uint8_t> encoded(const ModelImage& image, const Snapshot& snapshot) {
  constexpr std::uint32_t kThumbnailPx = 128, kPosterPx = 640;
  const StoredView& view = *snapshot.views[image.slot];
  give_back_scratch_pages();
  switch (image.kind) {
    case ModelImageKind::lens_mask:
      return encode_image(grey_image(view.camera, view.photograph->valid()), image.coding);
    case ModelImageKind::trust_mask:
      return encode_image(grey_image(view.camera, view.mask->trust.all()), image.coding);
    case ModelImageKind::mask:
      return mask_file(view, image.effort);
    case ModelImageKind::thumbnail:
      return small_file(snapshot, image.slot, kThumbnailPx, image.coding);
    case ModelImageKind::poster:
      return small_file(snapshot, image.slot, kPosterPx, image.coding);
    case ModelImageKind::photograph:
      break;
  }
  return encode_image(resident_part(snapshot, image.slot, image.coding.format), image.coding);
}

}  // namespace lumatlas
