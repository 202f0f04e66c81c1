// SPDX-License-Identifier: GPL-3.0-or-later
// Shared by the main functions of the benchmark programs: memory and exit codes as those of `lumatlas`.
#pragma once

#include <CLI/CLI.hpp>
#include <exception>
#include <functional>
#include <iostream>

#include "mesh/base/freed_memory.h"

namespace lumatlas {

// Parses the arguments, which runs subcommands, and then runs `run`, if given. Returns the exit code.
inline int run_program(CLI::App& program, const char* name, int argc, char** argv,
                       const std::function<void()>& run = {}) {
  keep_freed_memory();
  try {
    program.parse(argc, argv);
    if (run) run();
    return 0;
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::cerr << name << ": " << error.what() << '\n';
    return 1;
  }
}

}  // namespace lumatlas
