// SPDX-License-Identifier: GPL-3.0-or-later
// What a folder holds that is no form of capture that this program reads.
#pragma once

#include <filesystem>
#include <string>

namespace lumatlas {

// What to say after "PATH: holds no ...", beginning with "; ": the form that is there and is not read, with those that
// are; else that photographs are there, and the command that finds out where they were taken. Empty where the folder
// has neither. Never throws: what cannot be looked at is not there.
[[nodiscard]] std::string unread_form_hint(const std::filesystem::path& scene);

// "PATH: holds no COLMAP model (...) and no transforms.json or other form of capture", with the hint.
[[nodiscard]] std::string no_poses(const std::filesystem::path& scene);

}  // namespace lumatlas
