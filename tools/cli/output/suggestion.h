// SPDX-License-Identifier: GPL-3.0-or-later
// Suggests the command or option that a mistyped name may stand for.
#pragma once

#include <CLI/App.hpp>
#include <string>

namespace lumatlas {

// A sentence that names the command, option or setting that is nearest to one which the program does not know, or "":
// after program.parse(argc, argv) has thrown.
[[nodiscard]] std::string suggestion(const CLI::App& program, int argc, const char* const* argv);

}  // namespace lumatlas
