// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/mask_pass.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "blend/gl/egl_context.h"
#include "blend/gl/gl_state.h"
#include "blend/shaders.h"

namespace lumatlas {

namespace {

// A corner of a part: its place in the page, and in the masks that were copied to the GPU.
struct PartCorner {
  std::array<GLint, 2> place;
  std::array<GLint, 3> mask;
};

// Returns the corners of two triangles for each part.
std::vector<PartCorner> corners_of(std::span<const PlacedMask> masks, GLint width, GLint height) {
  constexpr std::array<std::array<GLint, 2>, 6> kCorners{{{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}}};
  std::vector<PartCorner> corners;
  corners.reserve(kCorners.size() * masks.size());
  for (std::size_t i = 0; i < masks.size(); ++i) {
    for (const auto [right, down] : kCorners) {
      corners.push_back(
          {{static_cast<GLint>(masks[i].x) + right * width, static_cast<GLint>(masks[i].y) + down * height},
           {right * width, down * height, static_cast<GLint>(i)}});
    }
  }
  return corners;
}

GlTexture copied(std::span<const PlacedMask> masks, std::uint32_t width, std::uint32_t height) {
  std::vector<std::uint8_t> values;
  values.reserve(std::size_t{width} * height * masks.size());
  for (const PlacedMask& mask : masks) values.insert(values.end(), mask.validity.begin(), mask.validity.end());
  const auto columns = static_cast<GLsizei>(width), rows = static_cast<GLsizei>(height);
  const auto layers = static_cast<GLsizei>(masks.size());
  GlTexture texture = make_texture_array(GL_R8, columns, rows, layers, GL_NEAREST);
  glTexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, columns, rows, layers, GL_RED, GL_UNSIGNED_BYTE, values.data());
  return texture;
}

GlVertexArray vertices_of(const GlBuffer& corners) {
  GLuint name = 0;
  glGenVertexArrays(1, &name);
  GlVertexArray vertices(name);
  glBindVertexArray(name);
  glBindBuffer(GL_ARRAY_BUFFER, corners.get());
  // OpenGL takes an offset in the buffer as a pointer. NOLINTNEXTLINE(performance-no-int-to-ptr)
  const auto* const mask = reinterpret_cast<const void*>(offsetof(PartCorner, mask));
  glVertexAttribPointer(0, 2, GL_INT, GL_FALSE, sizeof(PartCorner), nullptr);
  glVertexAttribPointer(1, 3, GL_INT, GL_FALSE, sizeof(PartCorner), mask);
  glEnableVertexAttribArray(0);
  glEnableVertexAttribArray(1);
  return vertices;
}

GlProgram mask_program() {
  GlProgram program = make_program("masks", k_mask_vert, k_mask_frag);
  glUseProgram(program.get());
  glUniform1i(glGetUniformLocation(program.get(), "masks"), static_cast<GLint>(kSpareUnit));
  return program;
}

}  // namespace

void MaskPass::write(const GlTexture& photographs, std::uint32_t width, std::uint32_t height,
                     std::span<const PlacedMask> masks) {
  std::vector<PlacedMask> by_page(masks.begin(), masks.end());
  std::stable_sort(by_page.begin(), by_page.end(),
                   [](const PlacedMask& a, const PlacedMask& b) { return a.page < b.page; });
  const auto most = static_cast<std::size_t>(gl_limit(GL_MAX_ARRAY_TEXTURE_LAYERS));
  for (std::size_t first = 0; first < by_page.size(); first += most) {
    write_some(photographs, width, height, std::span(by_page).subspan(first, std::min(most, by_page.size() - first)));
  }
}

// Masks of one page follow each other.
void MaskPass::write_some(const GlTexture& photographs, std::uint32_t width, std::uint32_t height,
                          std::span<const PlacedMask> masks) {
  if (program_.get() == 0) program_ = mask_program();
  const std::vector<PartCorner> corners = corners_of(masks, static_cast<GLint>(width), static_cast<GLint>(height));
  const GlBuffer buffer = make_buffer(corners);
  const GlVertexArray vertices = vertices_of(buffer);
  glActiveTexture(GL_TEXTURE0 + kSpareUnit);
  const GlTexture copy = copied(masks, width, height);  // stays bound
  GLint page_width = 0, page_height = 0;
  for (const PlacedMask& mask : masks) {
    page_width = std::max(page_width, static_cast<GLint>(mask.x + width));
    page_height = std::max(page_height, static_cast<GLint>(mask.y + height));
  }
  GLuint name = 0;
  glGenFramebuffers(1, &name);
  const GlFramebuffer framebuffer(name);
  glBindFramebuffer(GL_FRAMEBUFFER, name);
  glUseProgram(program_.get());
  glUniform2f(glGetUniformLocation(program_.get(), "size"), static_cast<float>(page_width),
              static_cast<float>(page_height));
  glViewport(0, 0, page_width, page_height);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_TRUE);
  const std::size_t of_mask = corners.size() / masks.size();
  for (std::size_t first = 0, end = 0; first < masks.size(); first = end) {
    while (end < masks.size() && masks[end].page == masks[first].page) ++end;
    glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, photographs.get(), 0,
                              static_cast<GLint>(masks[first].page));
    const GLenum status = first == 0 ? glCheckFramebufferStatus(GL_FRAMEBUFFER) : GL_FRAMEBUFFER_COMPLETE;
    if (status != GL_FRAMEBUFFER_COMPLETE) {
      glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
      throw GlError("the driver refuses to draw masks (status " + std::to_string(status) + ")");
    }
    glDrawArrays(GL_TRIANGLES, static_cast<GLint>(of_mask * first), static_cast<GLsizei>(of_mask * (end - first)));
  }
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  check_gl("writing masks");
}

}  // namespace lumatlas
