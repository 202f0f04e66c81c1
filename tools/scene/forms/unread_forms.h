// SPDX-License-Identifier: GPL-3.0-or-later
// Names a form of capture in a folder that this program does not read.
#pragma once

#include <filesystem>
#include <string>

namespace lumatlas {

// Returns what to say after "PATH: holds no ...", beginning with "; ". If the folder has a form that is not read, it
// names that form and those that are read; else, if there are photographs, the command that finds their poses. Empty
// where the folder has neither. Never throws: files that cannot be read count as missing.
[[nodiscard]] std::string unread_form_hint(const std::filesystem::path& scene);

// "PATH: holds no COLMAP model (...) and no transforms.json or other form of capture", with the hint.
[[nodiscard]] std::string no_poses(const std::filesystem::path& scene);

}  // namespace lumatlas
