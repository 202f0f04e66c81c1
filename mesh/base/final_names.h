// SPDX-License-Identifier: GPL-3.0-or-later
// Sentences about outputs that are still being written: they name what the user named, and not the temporary file or
// folder that is gone by the time the sentence is read.
#pragma once

#include <filesystem>
#include <string>

namespace lumatlas {

// Notes that what is written at `temporary` is to become `target`. From any thread.
void note_final_name(const std::filesystem::path& temporary, const std::filesystem::path& target);

// Forgets it again, once the output is in its place. From any thread.
void forget_final_name(const std::filesystem::path& temporary);

// The sentence with each temporary path that was noted replaced by its target. From any thread.
[[nodiscard]] std::string with_final_names(std::string sentence);

}  // namespace lumatlas
