// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/picture_targets.h"

#include <algorithm>
#include <string>

#include "blend/gl/egl_context.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

SurfaceTargets surface_targets(std::uint32_t width, std::uint32_t height) {
  const auto w = static_cast<GLsizei>(width);
  const auto h = static_cast<GLsizei>(height);
  SurfaceTargets targets;
  targets.surface = make_texture_2d(GL_RGBA32UI, w, h);
  targets.z_buffer = make_texture_2d(GL_DEPTH32F_STENCIL8, w, h);
  targets.pass = make_framebuffer({&targets.surface}, &targets.z_buffer, true);
  return targets;
}

}  // namespace

PictureTargets make_targets(std::uint32_t width, std::uint32_t height) {
  require_picture_size(width, height);
  PictureTargets targets;
  targets.width = width;
  targets.height = height;
  targets.middles = surface_targets(width, height);
  targets.picture = make_texture_2d(GL_RGBA8, static_cast<GLsizei>(width), static_cast<GLsizei>(height));
  targets.pass = make_framebuffer({&targets.picture}, &targets.middles.z_buffer, true);
  return targets;
}

void add_samples(PictureTargets& targets, std::uint32_t across) {
  if (targets.samples_across == across) return;
  targets.samples_across = 0;
  targets.samples = {};
  const auto most = static_cast<std::uint32_t>(gl_limit(GL_MAX_TEXTURE_SIZE));
  if (std::uint64_t{across} * std::max(targets.width, targets.height) > most) {
    throw GlError("a picture of " + size_text(targets.width, targets.height) + " with " + std::to_string(across) +
                  " samples across a pixel is above this driver's limit of " + std::to_string(most) +
                  " a side: render it smaller or with fewer samples");
  }
  targets.samples = surface_targets(across * targets.width, across * targets.height);
  targets.samples_across = across;
}

void add_soft_edges(PictureTargets& targets) {
  if (targets.sharp_pass.get() != 0) return;
  const auto w = static_cast<GLsizei>(targets.width);
  const auto h = static_cast<GLsizei>(targets.height);
  targets.edges = make_texture_2d(GL_R32UI, w, h);
  targets.edges_pass = make_framebuffer({&targets.edges}, nullptr);
  targets.edge_rows = make_texture_2d(GL_R32UI, w, h);
  targets.edge_rows_pass = make_framebuffer({&targets.edge_rows}, nullptr);
  targets.sharp = make_texture_2d(GL_RGBA8, w, h);
  targets.sharp_pass = make_framebuffer({&targets.sharp}, nullptr);
}

void read_values(const GlFramebuffer& framebuffer, GLenum attachment, GLenum format, GLenum type,
                 const PictureTargets& targets, std::size_t bytes_per_pixel, std::byte* values) {
  constexpr std::size_t kStripBytes = 1 << 26;
  const std::size_t row = bytes_per_pixel * targets.width;
  const std::size_t strip_rows = std::max<std::size_t>(1, kStripBytes / row);
  std::vector<std::byte> strip(row * std::min<std::size_t>(strip_rows, targets.height));
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.get());
  glReadBuffer(attachment);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  for (std::size_t first = 0; first < targets.height; first += strip_rows) {
    const std::size_t rows = std::min(strip_rows, targets.height - first);
    glReadPixels(0, static_cast<GLint>(first), static_cast<GLsizei>(targets.width), static_cast<GLsizei>(rows), format,
                 type, strip.data());
    for (std::size_t y = 0; y < rows; ++y) {
      std::copy_n(&strip[row * y], row, values + row * (targets.height - 1 - first - y));
    }
  }
  check_gl("reading the picture");
}

}  // namespace lumatlas
