// SPDX-License-Identifier: GPL-3.0-or-later
// Decides which files an export may replace: those that an earlier export wrote. Any other file could be the user's
// only copy.
#pragma once

#include <filesystem>

namespace lumatlas {

// Throws InputError where a file stands there that is no glTF of `lumatlas export`.
void check_replaceable_export(const std::filesystem::path& file);

// Throws InputError where a file stands there that is no page of `lumatlas export`.
void check_replaceable_page(const std::filesystem::path& file);

}  // namespace lumatlas
