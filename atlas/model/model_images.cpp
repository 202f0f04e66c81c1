// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/model_images.h"

#include <algorithm>
#include <span>

namespace lumatlas {

namespace {

std::string numbered(std::size_t view) {
  std::string number = std::to_string(view);
  number.insert(0, number.size() < 5 ? 5 - number.size() : 0, '0');
  return std::string(kImageFolder) + "/" + number;
}

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
Photograph resident_part(const Snapshot& snapshot, std::uint32_t slot, ImageFormat format) {
  const StoredView& view = *snapshot.views[slot];
  Photograph part = *view.photograph;
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

std::vector<ModelImage> images_of(const Snapshot& snapshot, const ImageCoding& photographs) {
  std::vector<ModelImage> images;
  std::size_t number = 0;
  for (std::uint32_t slot = 0; slot < snapshot.views.size(); ++slot) {
    if (!snapshot.views[slot]) continue;
    const StoredView& view = *snapshot.views[slot];
    const std::string name = numbered(number++);
    images.push_back({ModelImageKind::photograph, slot, {name, ending(photographs.format)}, photographs});
    if (!view.photograph->valid.empty())
      images.push_back({ModelImageKind::lens_mask, slot, {name + "-lens", ".png"}, {}});
    if (!view.mask->trust.empty()) images.push_back({ModelImageKind::trust_mask, slot, {name + "-trust", ".png"}, {}});
  }
  return images;
}

ModelFileName texture_name(const ImageCoding& coding) {
  return {std::string(kImageFolder) + "/texture", ending(coding.format)};
}

std::vector<std::uint8_t> encoded(const ModelImage& image, const Snapshot& snapshot) {
  const StoredView& view = *snapshot.views[image.slot];
  switch (image.kind) {
    case ModelImageKind::lens_mask:
      return encode_image(grey_image(view.camera, view.photograph->valid), image.coding);
    case ModelImageKind::trust_mask:
      return encode_image(grey_image(view.camera, view.mask->trust), image.coding);
    case ModelImageKind::photograph:
      break;
  }
  return encode_image(resident_part(snapshot, image.slot, image.coding.format), image.coding);
}

}  // namespace lumatlas
