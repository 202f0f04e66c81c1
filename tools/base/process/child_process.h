// SPDX-License-Identifier: GPL-3.0-or-later
// Another program, run to its end.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace lumatlas {

// An absolute or relative path, or a name that PATH has. Its standard input is empty, its outputs go to these files,
// which may be one and the same.
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

// The first of PATH's programs of this name; empty: none.
[[nodiscard]] std::filesystem::path find_program(const std::string& name);

// The command line as one would type it into a shell.
[[nodiscard]] std::string shell_line(const std::string& program, const std::vector<std::string>& arguments);

}  // namespace lumatlas
