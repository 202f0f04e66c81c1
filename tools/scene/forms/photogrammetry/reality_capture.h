// SPDX-License-Identifier: GPL-3.0-or-later
// The CSV that RealityCapture (RealityScan) exports as "Internal/External camera parameters".
//
//   #name                photograph, by its file's name
//   x y alt              where the camera stands
//   heading pitch roll   degrees. At 0 0 0 the camera looks down, against alt, its right is +x and its up is +y; then
//                        world from camera = turn by -heading about alt * by pitch about x * by roll about y
//   f                    millimetres on film 36 mm wide: 36 is the longer side of the photograph
//   px py                the same, from the middle of the photograph to its principal point, right and down
//   k1 k2 k3 k4 t1 t2    Brown's, by the plane z = 1; t1 and t2 are OpenCV's p1 and p2
//
// Columns are found by these names, in the first line that has those up to f, with or without '#', which comments may
// precede; alt may be called z, heading yaw, and f f_35mm. Other columns are told in a note; distortion may be missing.
// Longitude and latitude in degrees are refused.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"

namespace lumatlas {

// Throws InputError that names line and value, and what the lookup throws.
[[nodiscard]] Capture parse_reality_capture(std::string_view text, const std::filesystem::path& path,
                                            const PhotographLookup& photographs);

// The first .csv, by name, that has such columns.
[[nodiscard]] std::optional<std::filesystem::path> find_reality_capture(const std::filesystem::path& scene);
[[nodiscard]] Capture read_reality_capture(const CaptureRequest& request);

}  // namespace lumatlas
