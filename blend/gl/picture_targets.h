// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: what a picture is drawn into.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "blend/gl/gl_objects.h"

namespace lumatlas {

// The visible surface, as shaders/surface_texel.glsl has it, with its depth and a stencil.
struct SurfaceTargets {
  GlTexture surface, z_buffer;
  GlFramebuffer pass;
};

// The middles' stencil tells which pixels are blended how; the samples' is a copy of it.
struct PictureTargets {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  SurfaceTargets middles;  // one texel a pixel
  GlTexture picture;       // RGBA8
  GlFramebuffer pass;      // the picture, with the stencil of `middles`
  std::uint32_t samples_across = 0;
  SurfaceTargets samples;  // that many times as wide and high; made when first asked for
  // The variances of the blur at depth edges, and their spread along rows, bits of floats; the picture before it is
  // blurred, RGBA8. Made when first asked for.
  GlTexture edges, edge_rows, sharp;
  GlFramebuffer edges_pass, edge_rows_pass, sharp_pass;
};

// All throw GlError for what the driver does not take.
[[nodiscard]] PictureTargets make_targets(std::uint32_t width, std::uint32_t height);
void add_samples(PictureTargets& targets, std::uint32_t across);
void add_soft_edges(PictureTargets& targets);

// All values of a framebuffer's color attachment, from the picture's first row, which is the framebuffer's last. In
// strips, for GL counts the bytes of each in 31 bits.
void read_values(const GlFramebuffer& framebuffer, GLenum attachment, GLenum format, GLenum type,
                 const PictureTargets& targets, std::size_t bytes_per_pixel, std::byte* values);

template <typename T>
[[nodiscard]] std::vector<T> values_of(const GlFramebuffer& framebuffer, GLenum attachment, GLenum format, GLenum type,
                                       const PictureTargets& targets, std::size_t values_per_pixel) {
  std::vector<T> values(values_per_pixel * targets.width * targets.height);
  read_values(framebuffer, attachment, format, type, targets, values_per_pixel * sizeof(T),
              reinterpret_cast<std::byte*>(values.data()));
  return values;
}

}  // namespace lumatlas
