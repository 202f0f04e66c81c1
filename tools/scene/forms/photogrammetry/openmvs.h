// SPDX-License-Identifier: GPL-3.0-or-later
// OpenMVS's exchange files, .mvs, which begin with MVSI: little-endian, a count of 64 bits before every list and text.
//
//   camera  K in pixels, with its skew, the middle of the first pixel at (0, 0); where it has no size, K by the
//           photograph's longer side
//   pose    camera from world = R (X - C), z forward with y down; a platform's camera has a pose in it of its own
//   image   the file, relative to the .mvs file, or the end of a path to it in the folder of photographs
//
// Photographs are undistorted. Those without a pose are left out and counted. Points, lines and depths are not
// read, masks are told in a note. A file that OpenMVS saved as its own archive ("MVS" and a zero) is not one of these.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>

#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"

namespace lumatlas {

// Throws InputError that names the entry and its index, and what the lookup throws. Allocates no more than a small
// multiple of the bytes that it is given.
[[nodiscard]] Capture parse_openmvs(std::span<const std::byte> file, const std::filesystem::path& path,
                                    const PhotographLookup& photographs);

// The first .mvs file, by name, that begins so.
[[nodiscard]] std::optional<std::filesystem::path> find_openmvs(const std::filesystem::path& scene);
[[nodiscard]] Capture read_openmvs(const CaptureRequest& request);

}  // namespace lumatlas
