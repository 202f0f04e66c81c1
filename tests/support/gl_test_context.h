// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "blend/egl_context.h"
#include "tests/support/skip.h"

namespace lumatlas {

// A context with GL debug output on; skips the test case, and gives nothing, where there is no OpenGL 4.5.
inline std::optional<EglContext> context_or_skip() {
  try {
    return EglContext({.debug = true});
  } catch (const GlError& error) {
    skip(std::string("no GL: ") + error.what());
    return std::nullopt;
  }
}

}  // namespace lumatlas
