// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/picture_targets.h"

#include <algorithm>
#include <vector>

#include "blend/gl/egl_context.h"

namespace lumatlas {

namespace {

constexpr std::uint64_t kSurfaceBytes = 16 + 8, kVarianceBytes = 4;  // of a pixel

SurfaceTargets surface_targets(std::uint32_t width, std::uint32_t height) {
  const auto w = static_cast<GLsizei>(width);
  const auto h = static_cast<GLsizei>(height);
  SurfaceTargets targets;
  targets.surface = make_texture_2d(GL_RGBA32UI, w, h);
  targets.z_buffer = make_texture_2d(GL_DEPTH32F_STENCIL8, w, h);
  targets.pass = make_framebuffer({&targets.surface}, &targets.z_buffer, true);
  return targets;
}

GlTexture texture_for(const PartTargets& targets, GLenum format) {
  return make_texture_2d(format, static_cast<GLsizei>(targets.width), static_cast<GLsizei>(targets.height));
}

void add_picture(const PartTargets& targets, ColorTargets& colors, GLenum format) {
  colors.picture = texture_for(targets, format);
  colors.pass = make_framebuffer({&colors.picture}, &targets.middles.z_buffer, true);
}

std::uint64_t pixels_of(const PartTargets& targets) {
  return std::uint64_t{targets.width} * targets.height;
}

}  // namespace

PartTargets make_part_targets(std::uint32_t width, std::uint32_t height) {
  PartTargets targets;
  targets.width = width;
  targets.height = height;
  targets.middles = surface_targets(width, height);
  add_picture(targets, targets.colors, GL_RGBA8);
  targets.bytes = pixels_of(targets) * (kSurfaceBytes + kColorBytes);
  return targets;
}

WholeTarget make_whole_target(std::uint32_t width, std::uint32_t height) {
  require_picture_size(width, height);
  WholeTarget target;
  target.width = width;
  target.height = height;
  target.picture = make_texture_2d(GL_RGBA8, static_cast<GLsizei>(width), static_cast<GLsizei>(height));
  target.pass = make_framebuffer({&target.picture}, nullptr);
  return target;
}

void add_samples(PartTargets& targets, std::uint32_t across) {
  if (targets.samples_across == across) return;
  targets.bytes -= pixels_of(targets) * kSurfaceBytes * targets.samples_across * targets.samples_across;
  targets.samples_across = 0;
  targets.samples = {};
  targets.samples = surface_targets(across * targets.width, across * targets.height);
  targets.samples_across = across;
  targets.bytes += pixels_of(targets) * kSurfaceBytes * across * across;
}

void add_copy(PartTargets& targets, ColorTargets& colors, GLenum format) {
  if (colors.copy_pass.get() != 0) return;
  colors.copy = texture_for(targets, format);
  colors.copy_pass = make_framebuffer({&colors.copy}, nullptr);
  if (&colors == &targets.colors) targets.bytes += pixels_of(targets) * kColorBytes;
}

void add_soft_edges(PartTargets& targets) {
  if (targets.edge_rows_pass.get() != 0) return;
  targets.edges = texture_for(targets, GL_R32UI);
  targets.edges_pass = make_framebuffer({&targets.edges}, &targets.middles.z_buffer, true);
  targets.edge_rows = texture_for(targets, GL_R32UI);
  targets.edge_rows_pass = make_framebuffer({&targets.edge_rows}, nullptr);
  targets.bytes += pixels_of(targets) * 2 * kVarianceBytes;
}

ColorTargets make_float_colors(const PartTargets& targets) {
  ColorTargets colors;
  add_picture(targets, colors, GL_RGBA32F);
  return colors;
}

void read_values(const GlFramebuffer& framebuffer, GLenum attachment, GLenum format, GLenum type,
                 const ReadPlace& place, std::size_t bytes_per_pixel, std::byte* image) {
  constexpr std::size_t kStripBytes = 1 << 26;
  const std::size_t row = bytes_per_pixel * place.width, image_row = bytes_per_pixel * place.image_width;
  const std::size_t strip_rows = std::max<std::size_t>(1, kStripBytes / row);
  std::vector<std::byte> strip(row * std::min<std::size_t>(strip_rows, place.height));
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.get());
  glReadBuffer(attachment);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  for (std::size_t first = 0; first < place.height; first += strip_rows) {
    const std::size_t rows = std::min(strip_rows, place.height - first);
    glReadPixels(static_cast<GLint>(place.x), static_cast<GLint>(place.y + first), static_cast<GLsizei>(place.width),
                 static_cast<GLsizei>(rows), format, type, strip.data());
    for (std::size_t y = 0; y < rows; ++y) {
      const std::size_t to = place.top + place.height - 1 - first - y;
      std::copy_n(&strip[row * y], row, image + image_row * to + bytes_per_pixel * place.left);
    }
  }
  check_gl("reading the picture");
}

}  // namespace lumatlas
