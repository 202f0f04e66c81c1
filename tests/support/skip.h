// SPDX-License-Identifier: GPL-3.0-or-later
// Test cases that cannot be checked on this machine, and say so.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace lumatlas {

// Records that the running test case, or the rest of it, is not checked here, and why ("there is no gnuplot"). The case
// then returns. A program in which something was skipped and nothing failed ends with kSkippedExitCode, and CTest calls
// that test skipped; it ends by listing what was skipped. Only on the thread that runs the test case.
void skip(const std::string& reason);

// The SKIP_RETURN_CODE that tests/CMakeLists.txt gives CTest.
inline constexpr int kSkippedExitCode = 77;

// The folder of the real scene NAME in the folder that the environment's LUMATLAS_SCENES names; skips where there is
// none.
[[nodiscard]] std::optional<std::filesystem::path> real_scene_or_skip(const std::string& name);

}  // namespace lumatlas
