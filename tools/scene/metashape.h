// SPDX-License-Identifier: GPL-3.0-or-later
// The XML that Agisoft Metashape exports its cameras to.
//
//   sensor/calibration  pixels; u = w / 2 + cx + x' (f + b1) + y' b2, v = h / 2 + cy + y' f, with (0, 0) the corner of
//   the
//                       picture. x' and y' are Brown's, whose p1 and p2 are OpenCV's p2 and p1. A fisheye's are the
//                       same of the angle from the axis instead of its tangent.
//   camera              label: the photograph's name, with or without its ending. transform: chunk from camera, 4 x 4
//   by
//                       rows; the camera looks along +z with y down. Those that are disabled or have no transform are
//                       left out and counted.
//   component, chunk    transform: world from chunk, scale * rotation + translation; a camera has that of its
//   component,
//                       else the chunk's, else none
//
// The first chunk with cameras is read.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "tools/scene/posed_photographs.h"

namespace lumatlas {

// Throws InputError that names sensor or camera and value, and what the lookup throws.
[[nodiscard]] PosedPhotographs parse_metashape(std::string_view text, const std::filesystem::path& path,
                                               const PhotographLookup& photographs);

// The first .xml, by name, that begins as such a file.
[[nodiscard]] std::optional<std::filesystem::path> find_metashape(const std::filesystem::path& scene);
[[nodiscard]] PosedPhotographs read_metashape(const std::filesystem::path& scene,
                                              const std::optional<std::filesystem::path>& images);

}  // namespace lumatlas
