// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <catch2/catch.hpp>
#include <optional>

#include "blend/egl_context.h"

namespace lumatlas {

// A context with GL debug output on; says so and gives nothing where there is no OpenGL 4.5.
inline std::optional<EglContext> context_or_skip() {
  try {
    return EglContext({.debug = true});
  } catch (const GlError& error) {
    WARN("skipped: " << error.what());
    return std::nullopt;
  }
}

}  // namespace lumatlas
