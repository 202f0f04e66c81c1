// SPDX-License-Identifier: GPL-3.0-or-later
// On what, and by which program, figures were measured.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace lumatlas {

// "AMD EPYC 7B13, 2 cores, 7.8 GiB, Linux 6.1.0": what the system tells.
[[nodiscard]] std::string machine_description();

// Returns how much memory the process has at the moment, bytes; 0 where the system does not tell.
[[nodiscard]] std::uint64_t resident_bytes();

// The running program's file.
[[nodiscard]] std::filesystem::path program_file();

// "0.1.0 commit 1a2b3c4d5e6f" where `commit` names a clean one. A program of a changed or unknown source is told apart
// from others by its file: "0.1.0 commit 1a2b3c4d5e6f-dirty (program 0123456789abcdef)".
[[nodiscard]] std::string program_identity(const std::string& version, const std::string& commit,
                                           const std::filesystem::path& program);

}  // namespace lumatlas
