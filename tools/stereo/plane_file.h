// SPDX-License-Identifier: GPL-3.0-or-later
// Plane maps on disk, so that memory holds a few of them and work that was stopped goes on where it was.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "tools/stereo/patch_match.h"

namespace lumatlas {

// Written beside its place, then renamed. `inputs` is the digest of what the map was made of. Throws InputError.
void write_planes(const std::filesystem::path& file, std::uint64_t inputs, const PlaneMap& map);

// None: there is no such file, it is not whole, or it was made of other inputs. For this machine's order of bytes.
[[nodiscard]] std::optional<PlaneMap> read_planes(const std::filesystem::path& file, std::uint64_t inputs);

}  // namespace lumatlas
