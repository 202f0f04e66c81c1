// SPDX-License-Identifier: GPL-3.0-or-later
// The same shaders in OpenGL ES 3.0, which is what a browser's WebGL 2 has.
#include <epoxy/gl.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "blend/gl/shader_program.h"
#include "blend/reference.h"
#include "blend/renderer.h"
#include "blend/shaders.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/rendering_difference.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

std::optional<EglContext> embedded_or_skip() {
  try {
    return EglContext({.debug = true, .embedded = true});
  } catch (const GlError& error) {
    skip(std::string("no GL ES: ") + error.what());
    return std::nullopt;
  }
}

TEST_CASE("an embedded context is OpenGL ES of at least 3.0, and says so") {
  const std::optional<EglContext> context = embedded_or_skip();
  if (!context) return;
  CHECK(context->description().find("OpenGL ES 3") != std::string::npos);
  CHECK_FALSE(epoxy_is_desktop_gl());
  CHECK(epoxy_gl_version() >= 30);
}

TEST_CASE("the picture's shaders are GLSL ES 3.00, and OpenGL ES compiles each with what WebGL 2 promises") {
  for (const std::string_view source :
       {k_surface_vert, k_surface_frag, k_screen_vert, k_blend_frag, k_diagnose_frag, k_silhouettes_frag, k_edges_frag,
        k_outline_rows_frag, k_outlines_frag, k_edge_rows_frag, k_soft_edges_frag, k_present_frag}) {
    CHECK(source.substr(0, source.find('\n')) == "#version 300 es");
    CHECK(source.find("gl_PrimitiveID") == std::string_view::npos);
    CHECK(source.find("#extension") == std::string_view::npos);
  }
  const std::optional<EglContext> context = embedded_or_skip();
  if (!context) return;
  ShaderPrograms programs;
  std::vector<ProgramKey> keys{{.pass = Pass::surface},    {.pass = Pass::silhouettes},
                               {.pass = Pass::edges},      {.pass = Pass::edge_rows},
                               {.pass = Pass::outlines},   {.pass = Pass::outline_rows},
                               {.pass = Pass::soft_edges}, {.pass = Pass::soft_edges, .output = Output::linear},
                               {.pass = Pass::present},    {.pass = Pass::present, .host_depth = true}};
  for (const std::uint32_t views : {1u, 3u, kMaxBlendedViews}) {
    keys.push_back({.pass = Pass::diagnose, .views = views});
    for (const Output output : {Output::srgb, Output::linear, Output::fetches}) {
      keys.push_back({.pass = Pass::blend, .views = views, .cells = 1, .output = output});
      keys.push_back({.pass = Pass::blend, .views = views, .cells = 2, .output = output});
      keys.push_back({.pass = Pass::blend, .views = views, .cells = 4, .output = output});
      keys.push_back({.pass = Pass::samples, .views = views, .cells = 4, .output = output});
      keys.push_back({.pass = Pass::blend, .views = views, .cells = 4, .output = output, .views_in_block = true});
      for (const bool cubic : {false, true}) {
        keys.push_back(
            {.pass = Pass::blend, .views = views, .cells = 4, .output = output, .cubic = cubic, .filtered_taps = true});
      }
    }
  }
  for (const ProgramKey& key : keys) {
    const GLuint program = programs.get(key);
    GLint uniforms = 0;
    GLint block_bytes = 0;
    GLint samplers = 0;
    glGetProgramiv(program, GL_ACTIVE_UNIFORMS, &uniforms);
    for (GLuint i = 0; i < static_cast<GLuint>(uniforms); ++i) {
      GLint block = 0;
      glGetActiveUniformsiv(program, 1, &i, GL_UNIFORM_BLOCK_INDEX, &block);
      samplers += block < 0;  // every other uniform is in the block
    }
    for (const char* name : {"Picture", "Views"}) {
      const GLuint block = glGetUniformBlockIndex(program, name);
      if (block == GL_INVALID_INDEX) continue;
      GLint bytes = 0;
      glGetActiveUniformBlockiv(program, block, GL_UNIFORM_BLOCK_DATA_SIZE, &bytes);
      block_bytes = std::max(block_bytes, bytes);
    }
    CHECK(samplers <= 16);
    CHECK(block_bytes <= 16384);
  }
}

TEST_CASE("in OpenGL ES pictures, linear pictures and diagnoses agree with the CPU reference") {
  const std::optional<EglContext> context = embedded_or_skip();
  if (!context) return;
  const Snapshot snapshot = room_snapshot(14, {});
  const auto visibility = make_ray_visibility(snapshot.surface->mesh);
  Renderer renderer;
  renderer.load(snapshot);
  for (const std::size_t number : {3u, 8u}) {
    Camera camera = room_camera(number).scaled_to(240, 180);
    camera.cam_from_world_translation += glm::dvec3(0.1, 0.05, -0.1);
    const VisibilityBuffer visible = visibility->trace(camera);
    for (const BlendOptions& options : {BlendOptions{}, BlendOptions::printed()}) {
      BlendOptions even = options;
      even.occlusion_tolerance = 0.02;  // with none, rounding decides at every pixel
      const Rendering cpu = render_reference(snapshot, camera, *visibility, even);
      CHECK(share_different(renderer.render(camera, even), cpu, 2) <= 0.001);
      const Diagnosis told = renderer.diagnose(camera, even);
      const Diagnosis expected = diagnose_reference(snapshot, camera, visible, even);
      std::size_t different = 0;
      for (std::size_t i = 0; i < told.pixels.size(); ++i)
        different += told.pixels[i].winner != expected.pixels[i].winner;
      CHECK(static_cast<double>(different) <= 0.002 * static_cast<double>(told.pixels.size()));
    }
    CHECK(renderer.render_linear(camera, {}).state == renderer.render(camera, {}).state);
  }
}

}  // namespace
}  // namespace lumatlas
