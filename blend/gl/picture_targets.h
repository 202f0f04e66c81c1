// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: what a picture is drawn into.
#pragma once

#include <cstddef>
#include <cstdint>

#include "blend/gl/gl_objects.h"

namespace lumatlas {

inline constexpr std::uint64_t kColorBytes = 4;  // of a pixel of RGBA8

// The visible surface, as shaders/surface_texel.glsl has it, with its depth and a stencil.
struct SurfaceTargets {
  GlTexture surface, z_buffer;
  GlFramebuffer pass;
};

// A picture's colours, RGBA8 or RGBA32F, and a framebuffer of them with the stencil of its surface.
struct ColorTargets {
  GlTexture picture;
  GlFramebuffer pass;
  // The picture before a pass that reads and changes it. Made when first asked for.
  GlTexture copy;
  GlFramebuffer copy_pass;
};

// What a part of a picture is drawn into. The middles' stencil tells which pixels are blended how; the samples' is a
// copy of it.
struct PartTargets {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  SurfaceTargets middles;  // one texel a pixel
  ColorTargets colors;     // RGBA8
  std::uint32_t samples_across = 0;
  SurfaceTargets samples;  // that many times as wide and high; made when first asked for
  // The variances of the blur at depth edges, and their spread along rows, bits of floats. Made when first asked for.
  GlTexture edges, edge_rows;
  GlFramebuffer edges_pass, edge_rows_pass;
  std::uint64_t bytes = 0;  // of all that are there, as they were asked for
};

// The picture as a whole, of RGBA8, which its parts are copied into.
struct WholeTarget {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  GlTexture picture;
  GlFramebuffer pass;
};

// All throw GlError for what the driver does not take.
[[nodiscard]] PartTargets make_part_targets(std::uint32_t width, std::uint32_t height);
[[nodiscard]] WholeTarget make_whole_target(std::uint32_t width, std::uint32_t height);
void add_samples(PartTargets& targets, std::uint32_t across);
// `colors`: those whose picture is copied, of `format`.
void add_copy(PartTargets& targets, ColorTargets& colors, GLenum format);
void add_soft_edges(PartTargets& targets);
// Returns colours of RGBA32F for the same part.
[[nodiscard]] ColorTargets make_float_colors(const PartTargets& targets);

// A rectangle of a framebuffer, and where its first row, which is the framebuffer's last, comes to in an image.
struct ReadPlace {
  std::uint32_t x, y, width, height;         // pixels of the framebuffer, from its lower left corner
  std::uint32_t left, top, image_width = 0;  // pixels of the image, from its top left corner
};

// Copies the values of a framebuffer's color attachment into an image. In strips, for GL counts the bytes of each in
// 31 bits.
void read_values(const GlFramebuffer& framebuffer, GLenum attachment, GLenum format, GLenum type,
                 const ReadPlace& place, std::size_t bytes_per_pixel, std::byte* image);

}  // namespace lumatlas
