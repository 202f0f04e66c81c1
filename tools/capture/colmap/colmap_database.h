// SPDX-License-Identifier: GPL-3.0-or-later
// Reads the photographs in COLMAP's database.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace lumatlas {

// Returns the ids of the images in COLMAP's database, by name. Throws InputError where the file cannot be read as such.
[[nodiscard]] std::map<std::string, std::uint32_t> image_ids(const std::filesystem::path& database);

}  // namespace lumatlas
