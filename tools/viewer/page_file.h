// SPDX-License-Identifier: GPL-3.0-or-later
// The owner's file beside a model: what its page says and shows besides the model (README.md). The page reads and
// checks it.
#pragma once

#include <filesystem>
#include <string>

namespace lumatlas {

// The file's name in a site.
inline constexpr const char* kPageFileName = "page.json";

// Returns where the owner's file of a model stands: beside its folder or .glb NAME, as NAME.page.json.
[[nodiscard]] std::filesystem::path page_file_of(const std::filesystem::path& model);

// Returns the text of a model's owner's file; empty: there is none. Throws InputError if it cannot be read, or is not
// JSON of an object.
[[nodiscard]] std::string read_page_file(const std::filesystem::path& model);

}  // namespace lumatlas
