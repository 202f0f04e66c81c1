// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "blend/gl/egl_context.h"
#include "tests/support/skip.h"

namespace lumatlas {

// A context with GL debug output on; skips the test case, and gives nothing, where there is no such OpenGL.
inline std::optional<EglContext> context_or_skip(const EglContext::Options& options = {.debug = true}) {
  try {
    return EglContext(options);
  } catch (const GlError& error) {
    skip(std::string("no GL: ") + error.what());
    return std::nullopt;
  }
}

// Drivers round the corners of faces to a 256th of a pixel. Mesa's takes depth from the exact corners nevertheless,
// others may take it from the rounded ones.
inline bool takes_depth_from_exact_corners(const EglContext& context) {
  return context.description().find("llvmpipe") != std::string::npos;
}

}  // namespace lumatlas
