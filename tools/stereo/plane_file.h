// SPDX-License-Identifier: GPL-3.0-or-later
// Plane maps on disk, so that memory holds a few of them and work that was stopped goes on where it was.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "tools/stereo/patch_match.h"

namespace lumatlas {

// Writes a plane map beside `file`, then renames it. `inputs`: digest of what the map was made from. Throws InputError.
void write_planes(const std::filesystem::path& file, std::uint64_t inputs, const PlaneMap& map);

// Returns the plane map, or none if the file is missing, damaged, or made from other inputs. The bytes are in the order
// of the machine that wrote them.
[[nodiscard]] std::optional<PlaneMap> read_planes(const std::filesystem::path& file, std::uint64_t inputs);

}  // namespace lumatlas
