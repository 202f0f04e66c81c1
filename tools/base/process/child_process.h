// SPDX-License-Identifier: GPL-3.0-or-later
// Starts other programs: run_to_end() waits for one, start_program() does not.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace lumatlas {

// A program to run: an absolute or relative path. Its standard input is empty, its outputs go to these files, which may
// be the same file.
struct ChildProcess {
  std::filesystem::path program;
  std::vector<std::string> arguments;
  std::filesystem::path out, err;
};

// Waits for it and returns its exit status, or minus the signal that ended it. Throws InputError where it cannot be
// started, and Interrupted, once it has ended, where the user has asked this program to stop. `while_waiting` is called
// again and again, many times a second; what that throws ends the other program, and is thrown on. The other program
// has a process group of its own. It is asked to end by SIGTERM, and killed 0.3 s later if it has not ended. What it
// has started in its group ends with it, and with this program, even where this program is killed. From any thread.
[[nodiscard]] int run_to_end(const ChildProcess& child, const std::function<void()>& while_waiting = {});

// The standard streams of a program: file descriptors; -1 stands for /dev/null.
struct StandardStreams {
  int in = -1, out = -1, err = -1;
};

// Starts a program and returns its process, for which the caller must wait (waitpid()). It has this program's process
// group and signal mask, and may outlive this program. Throws InputError if it cannot be started. From any thread.
[[nodiscard]] pid_t start_program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                                  const StandardStreams& streams = {});

// Returns the first of PATH's programs of this name; empty: none.
[[nodiscard]] std::filesystem::path find_program(const std::string& name);

// Returns the command line as it would be typed into a shell.
[[nodiscard]] std::string shell_line(const std::string& program, const std::vector<std::string>& arguments);

}  // namespace lumatlas
