// SPDX-License-Identifier: GPL-3.0-or-later
// Lists the files of a folder and of those below.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <system_error>
#include <vector>

namespace lumatlas {

struct FilesBelow {
  std::vector<std::string> names;  // relative to the folder, with '/', in byte order
  std::error_code error;           // for the first folder that could not be read; the files of the others are listed
};

// Lists the regular files, and links to such. Links to folders are followed. Each folder is listed once, under its own
// path if that is below `folder`, else under that of the first link, so that links may lead in circles; a link to a
// folder around `folder` is passed over. `passes_over` says of a path, `folder` first in it, that neither it nor what
// is below is listed; empty: everything is. At most a million entries are looked at. Never throws.
[[nodiscard]] FilesBelow files_below(const std::filesystem::path& folder,
                                     const std::function<bool(const std::filesystem::path&)>& passes_over = {});

}  // namespace lumatlas
