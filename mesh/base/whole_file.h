// SPDX-License-Identifier: GPL-3.0-or-later
// A file's bytes in one piece.
#pragma once

#include <filesystem>
#include <string>

namespace lumatlas {

// Throws InputError naming the path if there is no such regular file, it is empty, or it cannot be read to its end.
[[nodiscard]] std::string read_whole_file(const std::filesystem::path& path);

}  // namespace lumatlas
