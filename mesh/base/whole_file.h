// SPDX-License-Identifier: GPL-3.0-or-later
// A file's bytes in one piece.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "mesh/base/pending_file.h"

namespace lumatlas {

// Throws InputError naming the path if there is no such regular file, it is empty, or it cannot be read to its end. A
// pipe or a device is refused without waiting for what may come out of it. The bytes are a copy: what happens to the
// file later does not reach them.
[[nodiscard]] std::string read_whole_file(const std::filesystem::path& path);

// Writes beside `path`, then renames. Throws InputError naming the path unless every byte was taken.
void write_whole_file(const std::filesystem::path& path, std::string_view bytes,
                      Durability durability = Durability::on_disk);

}  // namespace lumatlas
