// SPDX-License-Identifier: GPL-3.0-or-later
// The program without its process: what main() does once signals and streams are seen to.
#pragma once

namespace lumatlas {

// Runs the command that the arguments ask for; the first is the program's name. Results go to std::cout or files,
// progress and errors to std::cerr. Returns the exit status: 0, 1 (it failed, one sentence says why), 2 (wrong usage).
// Throws Interrupted, and nothing else.
[[nodiscard]] int run_command_line(int argc, const char* const* argv);

}  // namespace lumatlas
