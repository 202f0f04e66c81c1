// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/egl_context.h"

#include <catch2/catch.hpp>
#include <optional>

#include "tests/gl_test_context.h"

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

TEST_CASE("a context can be moved and stays current") {
  std::optional<EglContext> first = context_or_skip();
  if (!first) return;
  const EglContext second = std::move(*first);
  first.reset();
  CHECK_FALSE(second.description().empty());
  CHECK_NOTHROW(check_gl("doing nothing"));
}

}  // namespace
}  // namespace lumatlas
