// SPDX-License-Identifier: GPL-3.0-or-later
// Source: the extension EXT_texture_compression_s3tc; integers are rounded as Mesa does.
#include "atlas/compressed_texels.h"

#include <algorithm>
#include <array>
#include <cstring>  // for stb_dxt.h, which has it not
#include <stdexcept>
#include <string>

#define STB_DXT_IMPLEMENTATION
#define STB_DXT_STATIC
#include <stb/stb_dxt.h>

#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

constexpr std::size_t kBlockTexels = 16;
constexpr std::size_t kAlphaBytes = 8;
using BlockAlpha = std::array<std::uint8_t, kBlockTexels>;
using AlphaPalette = std::array<std::uint8_t, 8>;

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

// With the first value above the second six values between both; else four, and 0 and 255.
AlphaPalette alpha_palette(std::uint32_t first, std::uint32_t second) {
  AlphaPalette palette{static_cast<std::uint8_t>(first), static_cast<std::uint8_t>(second), 0, 0, 0, 0, 0, 255};
  const std::uint32_t steps = first > second ? 7 : 5;
  for (std::uint32_t step = 1; step < steps; ++step) {
    palette[step + 1] = static_cast<std::uint8_t>(((steps - step) * first + step * second) / steps);
  }
  return palette;
}

struct AlphaBlock {
  std::uint32_t first = 0, second = 0;
  std::array<std::uint8_t, kBlockTexels> codes{};
  std::uint64_t error = 0;
};

// The nearest value of the palette for each texel; those that are shown stay shown, and those that are not, not.
AlphaBlock coded(const BlockAlpha& alpha, std::uint32_t first, std::uint32_t second) {
  constexpr std::uint32_t kOtherMeaning = 1u << 20;  // more than a block of the greatest errors
  AlphaBlock block{first, second, {}, 0};
  const AlphaPalette palette = alpha_palette(first, second);
  for (std::size_t i = 0; i < kBlockTexels; ++i) {
    std::uint32_t least = 2 * kOtherMeaning;
    for (std::size_t code = 0; code < palette.size(); ++code) {
      const int away = int{palette[code]} - int{alpha[i]};
      const bool same_meaning = (palette[code] == 0) == (alpha[i] == 0);
      const std::uint32_t error = static_cast<std::uint32_t>(away * away) + (same_meaning ? 0 : kOtherMeaning);
      if (error >= least) continue;
      least = error;
      block.codes[i] = static_cast<std::uint8_t>(code);
    }
    block.error += least;
  }
  return block;
}

// The better one of the ranges with and without a 0 and a 255 of their own. A contradicted pixel's validity of 1 beside
// 0 and 255 is so kept, which the nearest of equal steps would make 0: shown by no view at all.
AlphaBlock best_alpha(const BlockAlpha& alpha) {
  const auto [least, most] = std::minmax_element(alpha.begin(), alpha.end());
  std::uint32_t least_between = 255, most_between = 0;
  for (const std::uint8_t value : alpha) {
    if (value == 0 || value == 255) continue;
    least_between = std::min<std::uint32_t>(least_between, value);
    most_between = std::max<std::uint32_t>(most_between, value);
  }
  if (most_between == 0) least_between = most_between = *most;  // 0 and 255 alone
  AlphaBlock between = coded(alpha, least_between, most_between);
  if (between.error == 0) return between;
  AlphaBlock over_all = coded(alpha, *most, *least);
  return over_all.error < between.error ? over_all : between;
}

void compress_alpha(const BlockAlpha& alpha, std::uint8_t* out) {
  const AlphaBlock block = best_alpha(alpha);
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < kBlockTexels; ++i) bits |= std::uint64_t{block.codes[i]} << (3 * i);
  out[0] = static_cast<std::uint8_t>(block.first);
  out[1] = static_cast<std::uint8_t>(block.second);
  for (std::size_t i = 0; i < 6; ++i) out[2 + i] = static_cast<std::uint8_t>(bits >> (8 * i));
}

BlockAlpha decompressed_alpha(const std::uint8_t* block) {
  const AlphaPalette palette = alpha_palette(block[0], block[1]);
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < 6; ++i) bits |= std::uint64_t{block[2 + i]} << (8 * i);
  BlockAlpha alpha{};
  for (std::size_t i = 0; i < kBlockTexels; ++i) alpha[i] = palette[bits >> (3 * i) & 7];
  return alpha;
}

using Rgb = std::array<std::uint32_t, 3>;

// Of 5, 6 and 5 bits.
Rgb rgb_of(std::uint32_t packed) {
  const std::uint32_t r = packed >> 11, g = packed >> 5 & 63, b = packed & 31;
  return {r << 3 | r >> 2, g << 2 | g >> 4, b << 3 | b >> 2};
}

std::array<Rgb, kBlockTexels> decompressed_colors(const std::uint8_t* block) {
  const auto word = [&](std::size_t at) { return block[at] | std::uint32_t{block[at + 1]} << 8; };
  std::array<Rgb, 4> palette{rgb_of(word(0)), rgb_of(word(2))};
  for (std::size_t channel = 0; channel < 3; ++channel) {
    palette[2][channel] = (2 * palette[0][channel] + palette[1][channel]) / 3;
    palette[3][channel] = (palette[0][channel] + 2 * palette[1][channel]) / 3;
  }
  std::array<Rgb, kBlockTexels> colors{};
  for (std::size_t i = 0; i < kBlockTexels; ++i) colors[i] = palette[block[4 + i / 4] >> (2 * (i % 4)) & 3];
  return colors;
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
    BlockAlpha alpha{};
    std::array<std::uint8_t, 4 * kBlockTexels> opaque{};
    for (std::size_t i = 0; i < kBlockTexels; ++i) {
      const std::uint8_t* texel = &level.rgba[4 * texel_of_block(first, level.width, i)];
      std::copy_n(texel, 3, &opaque[4 * i]);
      opaque[4 * i + 3] = 255;
      alpha[i] = texel[3];
    }
    std::uint8_t* out = &blocks[kBlockBytes * block];
    compress_alpha(alpha, out);
    stb_compress_dxt_block(out + kAlphaBytes, opaque.data(), 0, STB_DXT_HIGHQUAL);
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
    const BlockAlpha alpha = decompressed_alpha(&blocks[kBlockBytes * block]);
    const auto colors = decompressed_colors(&blocks[kBlockBytes * block + kAlphaBytes]);
    for (std::size_t i = 0; i < kBlockTexels; ++i) {
      std::uint8_t* texel = &level.rgba[4 * texel_of_block(first, width, i)];
      for (std::size_t channel = 0; channel < 3; ++channel) {
        texel[channel] = static_cast<std::uint8_t>(colors[i][channel]);
      }
      texel[3] = alpha[i];
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
