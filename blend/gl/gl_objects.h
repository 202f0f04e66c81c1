// SPDX-License-Identifier: GPL-3.0-or-later
// One owning, move-only type per kind of GL object. All need the context that made them to be current.
#pragma once

#include <epoxy/gl.h>

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lumatlas {

// Owns a GL name; `Release` gives it back.
template <void (*Release)(GLuint)>
class GlHandle {
 public:
  GlHandle() = default;
  explicit GlHandle(GLuint name) : name_(name) {}
  ~GlHandle() { reset(); }
  GlHandle(GlHandle&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlHandle& operator=(GlHandle&& other) noexcept {
    if (this != &other) {
      reset();
      name_ = std::exchange(other.name_, 0);
    }
    return *this;
  }
  GlHandle(const GlHandle&) = delete;
  GlHandle& operator=(const GlHandle&) = delete;

  [[nodiscard]] GLuint get() const { return name_; }

 private:
  void reset() {
    if (name_ != 0) Release(name_);
    name_ = 0;
  }
  GLuint name_ = 0;
};

inline void release_buffer(GLuint name) {
  glDeleteBuffers(1, &name);
}
inline void release_texture(GLuint name) {
  glDeleteTextures(1, &name);
}
inline void release_framebuffer(GLuint name) {
  glDeleteFramebuffers(1, &name);
}
inline void release_vertex_array(GLuint name) {
  glDeleteVertexArrays(1, &name);
}
inline void release_shader(GLuint name) {
  glDeleteShader(name);
}
inline void release_program(GLuint name) {
  glDeleteProgram(name);
}

using GlBuffer = GlHandle<release_buffer>;
using GlTexture = GlHandle<release_texture>;
using GlFramebuffer = GlHandle<release_framebuffer>;
using GlVertexArray = GlHandle<release_vertex_array>;
using GlShader = GlHandle<release_shader>;
using GlProgram = GlHandle<release_program>;

// Immutable; never of size 0, which GL refuses: an empty span gives 16 zero bytes.
[[nodiscard]] GlBuffer make_buffer(std::span<const std::byte> bytes);

template <typename T>
[[nodiscard]] GlBuffer make_buffer(const std::vector<T>& values) {
  return make_buffer(std::as_bytes(std::span(values)));
}

// Returns the bytes that make_buffer() allocates.
[[nodiscard]] constexpr std::uint64_t buffer_bytes(std::size_t bytes) {
  return bytes > 0 ? bytes : 16;
}
template <typename T>
[[nodiscard]] std::uint64_t buffer_bytes(const std::vector<T>& values) {
  return buffer_bytes(sizeof(T) * values.size());
}

[[nodiscard]] GlTexture make_texture_2d(GLenum format, GLsizei width, GLsizei height);
// Tables of any length are rows of this many entries of a texture, which every OpenGL ES 3.0 takes. Shared with the
// shaders.
inline constexpr std::size_t kTableWidth = 2048;

struct GlTableFormat {
  GLenum internal;          // such as GL_R32UI
  GLenum format;            // such as GL_RED_INTEGER
  GLenum type;              // such as GL_UNSIGNED_INT
  std::size_t entry_bytes;  // bytes of one entry
};

inline constexpr GlTableFormat kNumbers{GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, sizeof(std::uint32_t)};
inline constexpr GlTableFormat kPairs{GL_RG32UI, GL_RG_INTEGER, GL_UNSIGNED_INT, 2 * sizeof(std::uint32_t)};
inline constexpr GlTableFormat kRecords{GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT, 4 * sizeof(std::uint32_t)};
inline constexpr GlTableFormat kVectors{GL_RGBA32F, GL_RGBA, GL_FLOAT, 4 * sizeof(float)};

// Rows of a table, of which there is one at least; and what make_table() allocates.
[[nodiscard]] constexpr std::size_t table_rows(std::size_t entries) {
  return entries > 0 ? (entries + kTableWidth - 1) / kTableWidth : 1;
}
[[nodiscard]] constexpr std::uint64_t table_bytes(const GlTableFormat& format, std::size_t entries) {
  return std::uint64_t{table_rows(entries)} * kTableWidth * format.entry_bytes;
}

// Entry i is the texel (i % kTableWidth, i / kTableWidth). Throws GlError, which names `what`, if the driver's textures
// are too small.
[[nodiscard]] GlTexture make_table(const GlTableFormat& format, std::span<const std::byte> entries, const char* what);

// The two steps of make_table(): the texture, and its rows with zeros after the last entry.
[[nodiscard]] GlTexture make_empty_table(const GlTableFormat& format, std::size_t entries, const char* what);
void copy_table_rows(const GlTexture& table, const GlTableFormat& format, std::span<const std::byte> entries,
                     std::size_t first_row, std::size_t rows);

// A table that changes: what stays is not copied again.
class GlTable {
 public:
  // `what` names the table in messages, as for make_table(), and outlives it.
  GlTable(const GlTableFormat& format, const char* what) : format_(format), what_(what) {}
  // The texture holds these entries already.
  GlTable(const GlTableFormat& format, const char* what, GlTexture texture, std::vector<std::byte> entries)
      : format_(format), what_(what), entries_(std::move(entries)), texture_(std::move(texture)) {}

  // Copies the entries from the first to the last that has changed since the call before, or all if there is another
  // number of them. Throws as make_table().
  void store(std::span<const std::byte> entries);
  [[nodiscard]] const GlTexture& texture() const { return texture_; }  // 0 before the first call

 private:
  GlTableFormat format_;
  const char* what_;
  std::vector<std::byte> entries_;  // that the texture holds
  GlTexture texture_;
};

// A linear `filter` also interpolates between levels if there are several.
[[nodiscard]] GlTexture make_texture_array(GLenum format, GLsizei width, GLsizei height, GLsizei layers, GLenum filter,
                                           GLsizei levels = 1);

// Color attachments in this order; `z_buffer` may be null, and its stencil comes along if that is asked for. It is
// bound afterwards. Throws GlError if the driver refuses it.
[[nodiscard]] GlFramebuffer make_framebuffer(std::initializer_list<const GlTexture*> colors, const GlTexture* z_buffer,
                                             bool with_stencil = false);

// Returns the driver's value for, say, GL_MAX_TEXTURE_SIZE.
[[nodiscard]] GLint gl_limit(GLenum name);

// Free GL memory, bytes, where the driver tells (NVIDIA, AMD); others allocate until the machine has no more.
[[nodiscard]] std::optional<std::uint64_t> free_gl_memory();

// Throws GlError with both numbers and what to do if `needed` bytes for `what` are more than are free.
void require_gl_memory(std::uint64_t needed, std::optional<std::uint64_t> available, const char* what,
                       const char* advice);

// Throws GlError for a picture above the driver's texture size or 2^29 pixels: OpenGL counts the bytes that it reads
// back, four a pixel, in 31 bits.
void require_picture_size(std::uint32_t width, std::uint32_t height);

// A program that the driver may still be compiling, on threads of its own if it has some.
struct PendingProgram {
  std::string name;
  GlShader vertex, fragment;
  GlProgram program;
};

// Starts to compile and link.
[[nodiscard]] PendingProgram start_program(std::string_view name, std::string_view vertex_source,
                                           std::string_view fragment_source);
// Waits until it is linked; throws GlError with the compiler's log and the shader's name.
[[nodiscard]] GlProgram finish_program(PendingProgram pending);
// Does both.
[[nodiscard]] GlProgram make_program(std::string_view name, std::string_view vertex_source,
                                     std::string_view fragment_source);

}  // namespace lumatlas
