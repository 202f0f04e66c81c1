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

// Returns whether `made` is there with the time of the file `source`: see mark_as_made_of().
[[nodiscard]] bool is_made_of(const std::filesystem::path& made, const std::filesystem::path& source);

// Gives `made` the time of the file that it was made of. Throws InputError.
void mark_as_made_of(const std::filesystem::path& made, const std::filesystem::path& source);

// Makes `link` a link to the file or folder `target`, in the place of another link; an empty `target` removes it. Where
// the file system has no links, a file becomes a copy, which a later call makes anew where the target's time has
// changed. Throws InputError, also for a folder on such a file system.
void put_link(const std::filesystem::path& link, const std::filesystem::path& target);

// Removes a file or folder, which need not be there. Throws InputError.
void remove_all_of(const std::filesystem::path& path);

}  // namespace lumatlas
