// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl_objects.h"

#include <array>
#include <string>

#include "blend/egl_context.h"

namespace lumatlas {

namespace {

GlShader compile(std::string_view name, GLenum stage, std::string_view source) {
  GlShader shader(glCreateShader(stage));
  const char* text = source.data();
  const auto length = static_cast<GLint>(source.size());
  glShaderSource(shader.get(), 1, &text, &length);
  glCompileShader(shader.get());
  GLint compiled = GL_FALSE;
  glGetShaderiv(shader.get(), GL_COMPILE_STATUS, &compiled);
  if (compiled == GL_TRUE) return shader;
  std::array<char, 2048> log{};
  glGetShaderInfoLog(shader.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  throw GlError("the driver refuses the " + std::string(stage == GL_VERTEX_SHADER ? "vertex" : "fragment") +
                " shader of " + std::string(name) + ": " + log.data());
}

}  // namespace

GlBuffer make_buffer(std::span<const std::byte> bytes) {
  GLuint name = 0;
  glCreateBuffers(1, &name);
  GlBuffer buffer(name);
  static constexpr std::array<std::byte, 16> kNothing{};
  const std::span<const std::byte> data = bytes.empty() ? std::span<const std::byte>(kNothing) : bytes;
  glNamedBufferStorage(name, static_cast<GLsizeiptr>(data.size()), data.data(), 0);
  check_gl("storing a buffer");
  return buffer;
}

GlTexture make_texture_2d(GLenum format, GLsizei width, GLsizei height) {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &name);
  GlTexture texture(name);
  glTextureStorage2D(name, 1, format, width, height);
  glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  check_gl("allocating a texture");
  return texture;
}

GlTexture make_texture_array(GLenum format, GLsizei width, GLsizei height, GLsizei layers, GLenum filter) {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
  GlTexture texture(name);
  glTextureStorage3D(name, 1, format, width, height, layers);
  glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, static_cast<GLint>(filter));
  glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, static_cast<GLint>(filter));
  glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  check_gl("allocating a texture array");
  return texture;
}

GlProgram make_program(std::string_view name, std::string_view vertex_source, std::string_view fragment_source) {
  const GlShader vertex = compile(name, GL_VERTEX_SHADER, vertex_source);
  const GlShader fragment = compile(name, GL_FRAGMENT_SHADER, fragment_source);
  GlProgram program(glCreateProgram());
  glAttachShader(program.get(), vertex.get());
  glAttachShader(program.get(), fragment.get());
  glLinkProgram(program.get());
  GLint linked = GL_FALSE;
  glGetProgramiv(program.get(), GL_LINK_STATUS, &linked);
  if (linked == GL_TRUE) return program;
  std::array<char, 2048> log{};
  glGetProgramInfoLog(program.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  throw GlError("the driver cannot link the shaders of " + std::string(name) + ": " + log.data());
}

}  // namespace lumatlas
