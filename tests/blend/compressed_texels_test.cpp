// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/tiles/compressed_texels.h"

#include <epoxy/gl.h>

#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "blend/gl/gl_objects.h"
#include "tests/support/gl_test_context.h"

namespace lumatlas {
namespace {

// Rows of blocks of noise: opaque, of one alpha, of any, and of hidden texels among others.
ImageLevel noise(std::uint32_t width, std::uint32_t height) {
  std::mt19937 random(11);
  ImageLevel level{width, height, {}};
  for (std::uint32_t y = 0; y < height; ++y) {
    const auto contrast = 1 + random() % 255;
    for (std::uint32_t x = 0; x < width; ++x) {
      for (int channel = 0; channel < 3; ++channel) {
        level.rgba.push_back(static_cast<std::uint8_t>((x + random() % contrast) % 256));
      }
      const auto kind = y / 4 % 4;
      const auto alpha = kind == 0 ? 255 : kind == 1 ? x / 4 % 256 : kind == 2 ? random() % 256 : random() % 2 * 255;
      level.rgba.push_back(static_cast<std::uint8_t>(alpha));
    }
  }
  return level;
}

TEST_CASE("a GPU shows of compressed texels what they are decompressed to, to the bit") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  constexpr GLsizei kWidth = 1024, kHeight = 64;
  const std::vector<std::uint8_t> blocks = compressed(noise(kWidth, kHeight));
  const GlTexture texture = make_texture_array(GL_COMPRESSED_RGBA_BPTC_UNORM, kWidth, kHeight, 1, GL_NEAREST, 1);
  glBindTexture(GL_TEXTURE_2D_ARRAY, texture.get());
  glCompressedTexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, kWidth, kHeight, 1, GL_COMPRESSED_RGBA_BPTC_UNORM,
                            static_cast<GLsizei>(blocks.size()), blocks.data());
  std::vector<std::uint8_t> shown(4 * blocks.size());
  glGetTexImage(GL_TEXTURE_2D_ARRAY, 0, GL_RGBA, GL_UNSIGNED_BYTE, shown.data());
  REQUIRE(glGetError() == GL_NO_ERROR);
  CHECK(shown == decompressed(kWidth, kHeight, blocks).rgba);
  std::array<std::size_t, 9> of_mode{};
  for (std::size_t block = 0; block < blocks.size(); block += kBlockBytes) ++of_mode[std::countr_zero(blocks[block])];
  CHECK(of_mode[4] > 1000);
  CHECK(of_mode[6] > 1000);
}

}  // namespace
}  // namespace lumatlas
