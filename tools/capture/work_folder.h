// SPDX-License-Identifier: GPL-3.0-or-later
// The folder that a capture works in.
#pragma once

#include <filesystem>

namespace lumatlas {

// Returns whether a path, once links are followed, lies in the folder or is it.
[[nodiscard]] bool is_within(const std::filesystem::path& path, const std::filesystem::path& folder);

// Throws InputError where an output lies among the photographs.
void check_outside(const std::filesystem::path& output, const std::filesystem::path& photographs);

// Makes the folder with its log/. Throws InputError unless it is new, empty, or an earlier capture's, whose record is
// `record`.
void open_work_folder(const std::filesystem::path& work, const std::filesystem::path& record);

// Makes `link` a link to `target`, in the place of another link; an empty `target` removes it. Throws InputError.
void put_link(const std::filesystem::path& link, const std::filesystem::path& target);

// Removes a file or folder, which need not be there. Throws InputError.
void remove_all_of(const std::filesystem::path& path);

}  // namespace lumatlas
