// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/egl_context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <catch2/catch.hpp>
#include <optional>
#include <thread>

#include "tests/support/gl_test_context.h"
#include "tests/support/skip.h"

namespace lumatlas {
namespace {

TEST_CASE("a context says what it is and can be made again after it is gone") {
  for (int round = 0; round < 3; ++round) {
    const std::optional<EglContext> context = context_or_skip();
    if (!context) return;
    CHECK(context->description().find("OpenGL 4.") != std::string::npos);
    CHECK_NOTHROW(check_gl("doing nothing"));
  }
}

TEST_CASE("where the display can tell, a context reports that the GPU was reset") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  auto* const display = eglGetCurrentDisplay();
  if (epoxy_egl_version(display) < 15 && !epoxy_has_egl_extension(display, "EGL_EXT_create_context_robustness")) {
    return skip("EGL without contexts that tell of a reset of the GPU");
  }
  GLint strategy = 0;
  glGetIntegerv(GL_RESET_NOTIFICATION_STRATEGY, &strategy);
  CHECK(strategy == GL_LOSE_CONTEXT_ON_RESET);
  CHECK(glGetGraphicsResetStatus() == GL_NO_ERROR);
  CHECK_NOTHROW(check_gl("asking"));
}

TEST_CASE("a context that shares with the current one leaves that current, and is drawn with on another thread") {
  const bool embedded = GENERATE(false, true);
  std::optional<EglContext> context = context_or_skip({.embedded = embedded});
  if (!context) return;
  auto* const before = eglGetCurrentContext();
  const EGLenum api = eglQueryAPI();
  std::optional<EglContext> sharing = EglContext::sharing_with_current();
  if (!sharing) return skip("a driver without contexts that share objects");
  CHECK(eglGetCurrentContext() == before);
  CHECK(eglQueryAPI() == api);
  GLuint name = 0;
  std::thread([&] {
    const CurrentContext current(*sharing);
    glGenTextures(1, &name);
    glBindTexture(GL_TEXTURE_2D, name);
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA8, 4, 4);
    glBindTexture(GL_TEXTURE_2D, 0);
    glFinish();
  }).join();
  CHECK(glIsTexture(name) == GL_TRUE);
  sharing.reset();
  CHECK(glIsTexture(name) == GL_TRUE);  // objects live as long as one of the contexts
  glDeleteTextures(1, &name);
  CHECK_NOTHROW(check_gl("sharing"));
}

TEST_CASE("without a current context there is none to share with") {
  CHECK(!EglContext::sharing_with_current());
}

TEST_CASE("what OpenGL reports becomes one sentence that says what to do") {
  CHECK(gl_error_sentence(GL_CONTEXT_LOST, "blending views") ==
        "the GPU was reset while blending views, and all that was on it is lost: run this again, with smaller pictures "
        "or fewer references if that happens more than once");
  CHECK(gl_error_sentence(GL_OUT_OF_MEMORY, "loading") ==
        "OpenGL ran out of memory while loading: use fewer views, smaller photographs or a coarser mesh");
  CHECK(gl_error_sentence(GL_INVALID_ENUM, "loading") == "OpenGL failed while loading: error 1280");
}

TEST_CASE("a context can be moved and stays current") {
  std::optional<EglContext> first = context_or_skip();
  if (!first) return;
  const EglContext second = std::move(*first);
  first.reset();
  CHECK_FALSE(second.description().empty());
  CHECK_NOTHROW(check_gl("doing nothing"));
}

TEST_CASE("a context that does not stay current is so only while it is asked for, on any thread") {
  if (!context_or_skip()) return;
  const EglContext aside({.debug = true, .stays_current = false});
  CHECK(eglGetCurrentContext() == EGL_NO_CONTEXT);
  const EglContext staying({.debug = true});
  const auto before = eglGetCurrentContext();
  REQUIRE(before != EGL_NO_CONTEXT);
  {
    const CurrentContext current(aside);
    CHECK(eglGetCurrentContext() != before);
    CHECK(eglGetCurrentContext() != EGL_NO_CONTEXT);
    {
      const EglContext third({.debug = true, .stays_current = false});
      const CurrentContext nested(third);
      CHECK_NOTHROW(check_gl("doing nothing"));
    }
    CHECK(eglGetCurrentContext() != before);
    CHECK(eglGetCurrentContext() != EGL_NO_CONTEXT);
  }
  CHECK(eglGetCurrentContext() == before);
  bool was_current = false;
  bool is_current = true;
  std::thread([&] {
    {
      const CurrentContext current(aside);
      was_current = eglGetCurrentContext() != EGL_NO_CONTEXT;
    }
    is_current = eglGetCurrentContext() != EGL_NO_CONTEXT;
  }).join();
  CHECK(was_current);
  CHECK_FALSE(is_current);
  CHECK(eglGetCurrentContext() == before);
}

TEST_CASE("a context that another thread has is refused, and what was current stays so") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  bool refused = false;
  bool kept = false;
  std::thread([&] {
    const EglContext own({.debug = true});
    const auto before = eglGetCurrentContext();
    try {
      const CurrentContext current(*context);
    } catch (const GlError&) {
      refused = true;
    }
    kept = eglGetCurrentContext() == before;
  }).join();
  CHECK(refused);
  CHECK(kept);
}

}  // namespace
}  // namespace lumatlas
