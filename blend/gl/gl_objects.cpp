// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/gl_objects.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <utility>

#include "blend/gl/egl_context.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

GlShader start_shader(GLenum stage, std::string_view source) {
  GlShader shader(glCreateShader(stage));
  const char* text = source.data();
  const auto length = static_cast<GLint>(source.size());
  glShaderSource(shader.get(), 1, &text, &length);
  glCompileShader(shader.get());
  return shader;
}

void require_compiled(const std::string& name, const char* stage, const GlShader& shader) {
  GLint compiled = GL_FALSE;
  glGetShaderiv(shader.get(), GL_COMPILE_STATUS, &compiled);
  if (compiled == GL_TRUE) return;
  std::array<char, 2048> log{};
  glGetShaderInfoLog(shader.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  throw GlError("the driver refuses the " + std::string(stage) + " shader of " + name + ": " + log.data());
}

}  // namespace

GlBuffer make_buffer(std::span<const std::byte> bytes) {
  GLuint name = 0;
  glGenBuffers(1, &name);
  GlBuffer buffer(name);
  static constexpr std::array<std::byte, buffer_bytes(std::size_t{0})> kNothing{};
  const std::span<const std::byte> data = bytes.empty() ? std::span<const std::byte>(kNothing) : bytes;
  glBindBuffer(GL_COPY_WRITE_BUFFER, name);  // a place that nothing is drawn from
  glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(data.size()), data.data(), GL_STATIC_DRAW);
  check_gl("storing a buffer");
  return buffer;
}

GlTexture make_texture_2d(GLenum format, GLsizei width, GLsizei height) {
  GLuint name = 0;
  glGenTextures(1, &name);
  GlTexture texture(name);
  glBindTexture(GL_TEXTURE_2D, name);
  glTexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  check_gl("allocating a texture");
  return texture;
}

GlTexture make_empty_table(const GlTableFormat& format, std::size_t entries, const char* what) {
  const std::size_t rows = table_rows(entries);
  const auto most = static_cast<std::size_t>(gl_limit(GL_MAX_TEXTURE_SIZE));
  if (rows > most) {
    throw GlError("the model needs " + std::to_string(entries) + " " + what + ", this driver takes " +
                  std::to_string(most * kTableWidth) + ": decimate the mesh or lower coverage.references");
  }
  return make_texture_2d(format.internal, static_cast<GLsizei>(kTableWidth), static_cast<GLsizei>(rows));
}

void copy_table_rows(const GlTexture& table, const GlTableFormat& format, std::span<const std::byte> entries,
                     std::size_t first_row, std::size_t rows) {
  const std::size_t row_bytes = kTableWidth * format.entry_bytes;
  const std::size_t first = std::min(first_row * row_bytes, entries.size());
  const std::span<const std::byte> present = entries.subspan(first, std::min(rows * row_bytes, entries.size() - first));
  std::vector<std::byte> padded(present.begin(), present.end());
  padded.resize(rows * row_bytes);
  glBindTexture(GL_TEXTURE_2D, table.get());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, static_cast<GLint>(first_row), static_cast<GLsizei>(kTableWidth),
                  static_cast<GLsizei>(rows), format.format, format.type, padded.data());
  check_gl("storing a table");
}

GlTexture make_table(const GlTableFormat& format, std::span<const std::byte> entries, const char* what) {
  const std::size_t count = (entries.size() + format.entry_bytes - 1) / format.entry_bytes;
  GlTexture table = make_empty_table(format, count, what);
  copy_table_rows(table, format, entries, 0, table_rows(count));
  return table;
}

void GlTable::store(std::span<const std::byte> entries) {
  if (texture_.get() == 0 || entries.size() != entries_.size()) {
    texture_ = {};
    texture_ = make_table(format_, entries, what_);
    entries_.assign(entries.begin(), entries.end());
    return;
  }
  const auto changed = std::mismatch(entries.begin(), entries.end(), entries_.begin());
  if (changed.first == entries.end()) return;
  const auto unchanged = std::mismatch(entries.rbegin(), entries.rend(), entries_.rbegin());
  const auto first = static_cast<std::size_t>(changed.first - entries.begin()) / format_.entry_bytes;
  const auto last = static_cast<std::size_t>(unchanged.first.base() - entries.begin() - 1) / format_.entry_bytes;
  glBindTexture(GL_TEXTURE_2D, texture_.get());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  for (std::size_t row = first / kTableWidth; row <= last / kTableWidth; ++row) {
    const std::size_t from = std::max(first, row * kTableWidth), to = std::min(last + 1, (row + 1) * kTableWidth);
    glTexSubImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(from % kTableWidth), static_cast<GLint>(row),
                    static_cast<GLsizei>(to - from), 1, format_.format, format_.type,
                    entries.data() + from * format_.entry_bytes);
  }
  check_gl("renewing a table");
  std::copy(entries.begin(), entries.end(), entries_.begin());
}

GlTexture make_texture_array(GLenum format, GLsizei width, GLsizei height, GLsizei layers, GLenum filter,
                             GLsizei levels) {
  GLuint name = 0;
  glGenTextures(1, &name);
  GlTexture texture(name);
  glBindTexture(GL_TEXTURE_2D_ARRAY, name);
  glTexStorage3D(GL_TEXTURE_2D_ARRAY, levels, format, width, height, layers);
  const bool between_levels = levels > 1 && filter == GL_LINEAR;
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER,
                  between_levels ? GL_LINEAR_MIPMAP_LINEAR : static_cast<GLint>(filter));
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, static_cast<GLint>(filter));
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  check_gl("allocating a texture array");
  return texture;
}

GlFramebuffer make_framebuffer(std::initializer_list<const GlTexture*> colors, const GlTexture* z_buffer,
                               bool with_stencil) {
  GLuint name = 0;
  glGenFramebuffers(1, &name);
  GlFramebuffer framebuffer(name);
  glBindFramebuffer(GL_FRAMEBUFFER, name);
  std::vector<GLenum> attachments;
  for (const GlTexture* color : colors) {
    attachments.push_back(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(attachments.size()));
    glFramebufferTexture2D(GL_FRAMEBUFFER, attachments.back(), GL_TEXTURE_2D, color->get(), 0);
  }
  if (z_buffer) {
    const GLenum attachment = with_stencil ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT;
    glFramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, z_buffer->get(), 0);
  }
  glDrawBuffers(static_cast<GLsizei>(attachments.size()), attachments.data());
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) {
    throw GlError("the driver refuses a framebuffer (status " + std::to_string(status) + ")");
  }
  return framebuffer;
}

GLint gl_limit(GLenum name) {
  GLint value = 0;
  glGetIntegerv(name, &value);
  return value;
}

std::optional<std::uint64_t> free_gl_memory() {
  GLint kibibytes[4] = {};  // AMD's query writes four numbers, of which the first is all that is free
  if (epoxy_has_gl_extension("GL_NVX_gpu_memory_info")) {
    glGetIntegerv(GL_GPU_MEMORY_INFO_CURRENT_AVAILABLE_VIDMEM_NVX, kibibytes);
  } else if (epoxy_has_gl_extension("GL_ATI_meminfo")) {
    glGetIntegerv(GL_TEXTURE_FREE_MEMORY_ATI, kibibytes);
  } else {
    return std::nullopt;
  }
  return std::uint64_t{1024} * static_cast<std::uint32_t>(kibibytes[0]);
}

void require_gl_memory(std::uint64_t needed, std::optional<std::uint64_t> available, const char* what,
                       const char* advice) {
  if (!available || needed <= *available) return;
  const auto mebibytes = [](std::uint64_t bytes) { return std::to_string((bytes + (1u << 20) - 1) >> 20) + " MiB"; };
  throw GlError("the model needs " + mebibytes(needed) + " of GPU memory for " + what + ", of which " +
                mebibytes(*available) + " are free: " + advice);
}

void require_picture_size(std::uint32_t width, std::uint32_t height) {
  constexpr std::uint64_t kMostPixels = std::numeric_limits<GLsizei>::max() / 4;
  const auto most = static_cast<std::uint32_t>(gl_limit(GL_MAX_TEXTURE_SIZE));
  if (std::max(width, height) > most) {
    throw GlError("a picture of " + size_text(width, height) + " is above this driver's limit of " +
                  std::to_string(most) + " pixels a side: render it smaller");
  }
  if (std::uint64_t{width} * height > kMostPixels) {
    throw GlError("a picture of " + size_text(width, height) + " has more than the " + std::to_string(kMostPixels) +
                  " pixels that OpenGL reads back at once: render it smaller");
  }
}

PendingProgram start_program(std::string_view name, std::string_view vertex_source, std::string_view fragment_source) {
  PendingProgram pending{std::string(name), start_shader(GL_VERTEX_SHADER, vertex_source),
                         start_shader(GL_FRAGMENT_SHADER, fragment_source), GlProgram(glCreateProgram())};
  glAttachShader(pending.program.get(), pending.vertex.get());
  glAttachShader(pending.program.get(), pending.fragment.get());
  glLinkProgram(pending.program.get());
  return pending;
}

GlProgram finish_program(PendingProgram pending) {
  GLint linked = GL_FALSE;
  glGetProgramiv(pending.program.get(), GL_LINK_STATUS, &linked);
  if (linked == GL_TRUE) return std::move(pending.program);
  require_compiled(pending.name, "vertex", pending.vertex);
  require_compiled(pending.name, "fragment", pending.fragment);
  std::array<char, 2048> log{};
  glGetProgramInfoLog(pending.program.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  throw GlError("the driver cannot link the shaders of " + pending.name + ": " + log.data());
}

GlProgram make_program(std::string_view name, std::string_view vertex_source, std::string_view fragment_source) {
  return finish_program(start_program(name, vertex_source, fragment_source));
}

}  // namespace lumatlas
