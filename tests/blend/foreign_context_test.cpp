// SPDX-License-Identifier: GPL-3.0-or-later
// The renderer in a context of another library, which has a state of its own.
#include <epoxy/gl.h>

#include <array>
#include <catch2/catch.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "blend/gl/gl_objects.h"
#include "blend/gl/gl_state.h"
#include "blend/renderer.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

// Everything that a renderer could have changed, by what it is called here.
using GlState = std::map<std::string, std::vector<GLint>>;

std::vector<GLint> values(GLenum name, std::size_t count = 1) {
  std::vector<GLint> result(4, 0);
  glGetIntegerv(name, result.data());
  result.resize(count);
  return result;
}

GlState state_now() {
  GlState state;
  const std::vector<std::pair<const char*, GLenum>> switches{{"cull", GL_CULL_FACE},
                                                             {"blend", GL_BLEND},
                                                             {"scissor", GL_SCISSOR_TEST},
                                                             {"offset", GL_POLYGON_OFFSET_FILL},
                                                             {"coverage", GL_SAMPLE_COVERAGE},
                                                             {"alpha to coverage", GL_SAMPLE_ALPHA_TO_COVERAGE},
                                                             {"dither", GL_DITHER},
                                                             {"stencil", GL_STENCIL_TEST},
                                                             {"depth", GL_DEPTH_TEST},
                                                             {"discard", GL_RASTERIZER_DISCARD}};
  for (const auto& [what, name] : switches) state[what] = {glIsEnabled(name)};
  const std::vector<std::pair<const char*, GLenum>> single{{"program", GL_CURRENT_PROGRAM},
                                                           {"vertex array", GL_VERTEX_ARRAY_BINDING},
                                                           {"array buffer", GL_ARRAY_BUFFER_BINDING},
                                                           {"copy buffer", GL_COPY_WRITE_BUFFER_BINDING},
                                                           {"pack buffer", GL_PIXEL_PACK_BUFFER_BINDING},
                                                           {"unpack buffer", GL_PIXEL_UNPACK_BUFFER_BINDING},
                                                           {"uniform buffer", GL_UNIFORM_BUFFER_BINDING},
                                                           {"draw framebuffer", GL_DRAW_FRAMEBUFFER_BINDING},
                                                           {"read framebuffer", GL_READ_FRAMEBUFFER_BINDING},
                                                           {"active texture", GL_ACTIVE_TEXTURE},
                                                           {"depth mask", GL_DEPTH_WRITEMASK},
                                                           {"depth function", GL_DEPTH_FUNC},
                                                           {"pack alignment", GL_PACK_ALIGNMENT},
                                                           {"pack row", GL_PACK_ROW_LENGTH},
                                                           {"unpack alignment", GL_UNPACK_ALIGNMENT},
                                                           {"unpack row", GL_UNPACK_ROW_LENGTH},
                                                           {"unpack skip", GL_UNPACK_SKIP_PIXELS},
                                                           {"stencil function", GL_STENCIL_FUNC},
                                                           {"stencil reference", GL_STENCIL_REF},
                                                           {"stencil mask", GL_STENCIL_VALUE_MASK},
                                                           {"stencil write mask", GL_STENCIL_WRITEMASK},
                                                           {"stencil pass", GL_STENCIL_PASS_DEPTH_PASS},
                                                           {"back stencil function", GL_STENCIL_BACK_FUNC},
                                                           {"back stencil write mask", GL_STENCIL_BACK_WRITEMASK}};
  for (const auto& [what, name] : single) state[what] = values(name);
  state["viewport"] = values(GL_VIEWPORT, 4);
  state["color mask"] = values(GL_COLOR_WRITEMASK, 4);
  state["clear color"] = values(GL_COLOR_CLEAR_VALUE, 4);
  for (const GLuint binding : {0u, 1u}) {
    GLint indexed = 0;
    glGetIntegeri_v(GL_UNIFORM_BUFFER_BINDING, binding, &indexed);
    state["uniform buffer " + std::to_string(binding)] = {indexed};
  }
  if (epoxy_is_desktop_gl()) {
    state["polygon mode"] = values(GL_POLYGON_MODE);
  }
  if (has_clip_control()) state["clip"] = {values(GL_CLIP_ORIGIN)[0], values(GL_CLIP_DEPTH_MODE)[0]};
  const GLint active = values(GL_ACTIVE_TEXTURE)[0];
  for (GLuint unit = 0; unit < 16; ++unit) {
    glActiveTexture(GL_TEXTURE0 + unit);
    state["unit " + std::to_string(unit)] = {values(GL_TEXTURE_BINDING_2D)[0], values(GL_TEXTURE_BINDING_2D_ARRAY)[0],
                                             values(GL_SAMPLER_BINDING)[0]};
  }
  glActiveTexture(static_cast<GLenum>(active));
  return state;
}

// A program that draws in its own way, with each setting another than the renderer's.
class Host {
 public:
  Host() {
    constexpr const char* kVertex = "#version 300 es\nvoid main() { gl_Position = vec4(0.0); }\n";
    constexpr const char* kFragment =
        "#version 300 es\nprecision highp float;\nout vec4 c;\nvoid main() { c = vec4(1.0); }\n";
    program_ = make_program("host", kVertex, kFragment);
    buffer_ = make_buffer(std::vector<float>(4096));
    flat_ = make_texture_2d(GL_RGBA8, 200, 200);
    layered_ = make_texture_array(GL_RGBA8, 8, 8, 2, GL_LINEAR);
    framebuffer_ = make_framebuffer({&flat_}, nullptr);
    constexpr std::array<GLfloat, 4> kClear{};
    glClearBufferfv(GL_COLOR, 0, kClear.data());
    GLuint name = 0;
    glGenVertexArrays(1, &name);
    vertex_array_ = GlVertexArray(name);
    glGenSamplers(1, &sampler_);
    glSamplerParameteri(sampler_, GL_TEXTURE_MIN_FILTER, GL_NEAREST_MIPMAP_NEAREST);
  }
  ~Host() { glDeleteSamplers(1, &sampler_); }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  void set_state() const {
    for (const GLenum name : {GL_CULL_FACE, GL_BLEND, GL_SCISSOR_TEST, GL_POLYGON_OFFSET_FILL, GL_SAMPLE_COVERAGE,
                              GL_STENCIL_TEST, GL_DEPTH_TEST, GL_RASTERIZER_DISCARD}) {
      glEnable(name);
    }
    glCullFace(GL_FRONT_AND_BACK);
    glScissor(1, 2, 3, 4);
    glViewport(5, 6, 70, 80);
    glColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_NEVER);
    glDepthRangef(0.5f, 0.25f);
    glStencilFuncSeparate(GL_FRONT, GL_NEVER, 3, 0x0F);
    glStencilFuncSeparate(GL_BACK, GL_LESS, 5, 0xF0);
    glStencilOp(GL_INVERT, GL_INCR, GL_DECR);
    glStencilMask(0x3C);
    glPixelStorei(GL_PACK_ALIGNMENT, 8);
    glPixelStorei(GL_PACK_ROW_LENGTH, 777);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 2);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 5555);
    glPixelStorei(GL_UNPACK_SKIP_PIXELS, 9);
    glUseProgram(program_.get());
    glBindVertexArray(vertex_array_.get());
    for (const GLenum target : {GL_ARRAY_BUFFER, GL_COPY_WRITE_BUFFER, GL_PIXEL_PACK_BUFFER, GL_PIXEL_UNPACK_BUFFER}) {
      glBindBuffer(target, buffer_.get());
    }
    glBindBufferRange(GL_UNIFORM_BUFFER, 0, buffer_.get(), 256, 512);
    glBindBufferRange(GL_UNIFORM_BUFFER, 1, buffer_.get(), 512, 256);
    for (GLuint unit = 0; unit < 16; ++unit) {
      glActiveTexture(GL_TEXTURE0 + unit);
      glBindTexture(GL_TEXTURE_2D, flat_.get());
      glBindTexture(GL_TEXTURE_2D_ARRAY, layered_.get());
      glBindSampler(unit, sampler_);
    }
    glActiveTexture(GL_TEXTURE3);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
    if (has_clip_control()) set_clip_control(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
    if (epoxy_is_desktop_gl()) {
      glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
      glEnable(GL_FRAMEBUFFER_SRGB);
    }
  }
  [[nodiscard]] GLuint framebuffer() const { return framebuffer_.get(); }

 private:
  GlProgram program_;
  GlBuffer buffer_;
  GlTexture flat_, layered_;
  GlFramebuffer framebuffer_;
  GlVertexArray vertex_array_;
  GLuint sampler_ = 0;
};

std::vector<std::uint8_t> rows_of(GLuint framebuffer, GLint x, GLint y, const Camera& camera) {
  GLint before = 0;
  glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &before);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glPixelStorei(GL_PACK_ROW_LENGTH, 0);
  std::vector<std::uint8_t> rgba(std::size_t{4} * camera.width * camera.height);
  glReadPixels(x, y, static_cast<GLsizei>(camera.width), static_cast<GLsizei>(camera.height), GL_RGBA, GL_UNSIGNED_BYTE,
               rgba.data());
  glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(before));
  return rgba;
}

// The picture, turned upside down as GL has it, where a surface is; elsewhere `untouched`.
void check_shows(const std::vector<std::uint8_t>& rgba, const Rendering& expected, std::uint8_t untouched) {
  const std::uint32_t width = expected.picture.width, height = expected.picture.height;
  std::size_t different = 0;
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      const std::size_t from = std::size_t{y} * width + x;
      const std::size_t to = std::size_t{height - 1 - y} * width + x;
      const bool empty = expected.state[from] == PixelState::empty;
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const std::uint8_t wanted = empty ? untouched : expected.picture.rgb[3 * from + channel];
        different += rgba[4 * to + channel] != wanted;
      }
    }
  }
  CHECK(different == 0);
}

void check_in(const EglContext::Options& options) {
  std::optional<EglContext> context;
  try {
    context.emplace(options);
  } catch (const GlError& error) {
    skip(std::string("no GL: ") + error.what());
    return;
  }
  const Snapshot snapshot = room_snapshot(6, {});
  Camera camera = room_camera(3).scaled_to(160, 120);
  camera.cam_from_world_translation.z += 3;  // from outside, so that some pixels see nothing
  Rendering expected;
  {
    Renderer alone;
    alone.load(snapshot);
    expected = alone.render(camera, {});
  }
  const Host host;
  host.set_state();
  const GlState before = state_now();
  const auto check_state = [&](const char* after) {
    CAPTURE(after);
    for (const auto& [what, value] : state_now()) {
      CAPTURE(what);
      CHECK(value == before.at(what));
    }
  };
  Renderer renderer;
  check_state("construction");
  renderer.load(snapshot);
  check_state("load");
  CHECK(renderer.picture_texture() == 0);
  const Rendering drawn = renderer.render(camera, {});
  check_state("render");
  CHECK(drawn.picture.rgb == expected.picture.rgb);
  CHECK(renderer.render_linear(camera, {}).state == expected.state);
  check_state("render_linear");
  CHECK(renderer.diagnose(camera, {}).state.size() == expected.state.size());
  check_state("diagnose");
  renderer.draw(camera, {});
  check_state("draw");
  REQUIRE(glIsTexture(renderer.picture_texture()) == GL_TRUE);
  renderer.draw_into(host.framebuffer(), 30, 40, camera, {});
  check_state("draw_into");
  check_shows(rows_of(host.framebuffer(), 30, 40, camera), expected, 0);
  host.set_state();
  Renderer gradual({.allocate_aside = true});
  NextSnapshot next = gradual.begin(snapshot, {});
  check_state("begin");
  next.prepare();
  while (!gradual.upload(0)) check_state("upload");
  check_state("the last upload");
  CHECK(gradual.render(camera, {}).picture.rgb == expected.picture.rgb);
}

TEST_CASE("in a foreign context with a state of its own pictures are the same, and the state stays") {
  check_in({.debug = true});
}

TEST_CASE("in a foreign context of OpenGL ES pictures are the same, and the state stays") {
  check_in({.debug = true, .embedded = true});
}

}  // namespace
}  // namespace lumatlas
