// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: writes validities into a texture array of photographs. Colours, in the same texels, stay.
#pragma once

#include <cstdint>
#include <span>

#include "blend/gl/gl_objects.h"

namespace lumatlas {

// A part of one page of the array, and its new validities, row by row.
struct PlacedMask {
  std::uint32_t x, y, page;  // of its first texel
  std::span<const std::uint8_t> validity;
};

class MaskPass {
 public:
  // Writes the alpha of parts of `width` x `height` texels, in the finest level of an array of GL_SRGB8_ALPHA8. The
  // driver draws it: OpenGL copies no channel alone. Binds a framebuffer, a program and a vertex array, and sets the
  // viewport; expects the state that GlStateGuard sets. Throws GlError if the driver refuses.
  void write(const GlTexture& photographs, std::uint32_t width, std::uint32_t height,
             std::span<const PlacedMask> masks);

 private:
  void write_some(const GlTexture& photographs, std::uint32_t width, std::uint32_t height,
                  std::span<const PlacedMask> masks);

  GlProgram program_;  // made when it is needed first
};

}  // namespace lumatlas
