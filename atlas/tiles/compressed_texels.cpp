// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/tiles/compressed_texels.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "atlas/tiles/bc7_block.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

static_assert(kBlockBytes == kBc7BlockBytes);

void require_blocks(std::uint32_t width, std::uint32_t height) {
  if (width % kBlockSide == 0 && height % kBlockSide == 0) return;
  throw std::invalid_argument("compressed texels: sides of " + size_text(width, height) + " are no multiples of " +
                              std::to_string(kBlockSide));
}

// Calls f(first texel of a block, number of the block) for each block of a picture.
template <typename F>
void for_each_block(std::uint32_t width, std::uint32_t height, const F& f) {
  std::size_t block = 0;
  for (std::size_t y = 0; y < height; y += kBlockSide) {
    for (std::size_t x = 0; x < width; x += kBlockSide) f(y * width + x, block++);
  }
}

std::size_t texel_of_block(std::size_t first, std::uint32_t width, std::size_t number) {
  return first + number / kBlockSide * width + number % kBlockSide;
}

ImageLevel part_of(const ImageLevel& level, std::uint32_t left, std::uint32_t top, std::uint32_t width,
                   std::uint32_t height) {
  ImageLevel part{width, height, {}};
  part.rgba.reserve(4 * std::size_t{width} * height);
  for (std::size_t row = top; row < std::size_t{top} + height; ++row) {
    const auto first = level.rgba.begin() + static_cast<std::ptrdiff_t>(4 * (row * level.width + left));
    part.rgba.insert(part.rgba.end(), first, first + static_cast<std::ptrdiff_t>(4 * std::size_t{width}));
  }
  return part;
}

std::uint32_t multiple_above(std::uint32_t value, std::uint32_t unit) {
  return (value + unit - 1) / unit * unit;
}

}  // namespace

std::vector<std::uint8_t> compressed(const ImageLevel& level) {
  require_blocks(level.width, level.height);
  std::vector<std::uint8_t> blocks(std::size_t{level.width} * level.height);  // a byte a texel
  for_each_block(level.width, level.height, [&](std::size_t first, std::size_t block) {
    BlockTexels texels{};
    for (std::size_t i = 0; i < texels.size(); ++i) {
      std::copy_n(&level.rgba[4 * texel_of_block(first, level.width, i)], 4, texels[i].begin());
    }
    const Bc7Block made = bc7_block(texels);
    std::copy(made.begin(), made.end(), &blocks[kBlockBytes * block]);
  });
  return blocks;
}

ImageLevel decompressed(std::uint32_t width, std::uint32_t height, std::span<const std::uint8_t> blocks) {
  require_blocks(width, height);
  if (blocks.size() != std::size_t{width} * height) {
    throw std::invalid_argument("compressed texels: " + std::to_string(blocks.size()) + " bytes of blocks, " +
                                size_text(width, height) + " texels have one a texel");
  }
  ImageLevel level{width, height, std::vector<std::uint8_t>(4 * blocks.size())};
  for_each_block(width, height, [&](std::size_t first, std::size_t block) {
    const BlockTexels texels = texels_of(blocks.subspan(kBlockBytes * block).first<kBlockBytes>());
    for (std::size_t i = 0; i < texels.size(); ++i) {
      std::copy_n(texels[i].begin(), 4, &level.rgba[4 * texel_of_block(first, width, i)]);
    }
  });
  return level;
}

// A slot begins with its gutter, so blocks are cut from that far before the view; as a tile's side is a multiple of 4
// in every level, those of all its slots are cut from the same grid.
std::vector<ImageLevel> shown_levels(const StoredView& view, const TileOptions& layout, std::uint32_t levels) {
  check(layout);
  const std::uint32_t most = levels_of(layout);
  if (levels < 1 || levels > most) {
    throw std::invalid_argument("shown levels: " + std::to_string(levels) + " levels are asked for, must be in [1, " +
                                std::to_string(most) + "]");
  }
  const std::uint32_t width = multiple_above(view.camera.width, 1u << (levels - 1));
  const std::uint32_t height = multiple_above(view.camera.height, 1u << (levels - 1));
  if (layout.texels == TexelFormat::rgb8) return image_levels(view, {0, 0, width, height}, levels);
  const std::uint32_t before = layout.whole_views() ? 0 : layout.gutter_px;
  const std::uint32_t unit = kBlockSide << (most - 1);
  const ImageRect around{-std::int64_t{before}, -std::int64_t{before}, multiple_above(before + width, unit),
                         multiple_above(before + height, unit)};
  std::vector<ImageLevel> shown = image_levels(view, around, levels);
  for (std::uint32_t level = 0; level < levels; ++level) {
    const ImageLevel seen = decompressed(shown[level].width, shown[level].height, compressed(shown[level]));
    shown[level] = part_of(seen, before >> level, before >> level, width >> level, height >> level);
  }
  return shown;
}

}  // namespace lumatlas
