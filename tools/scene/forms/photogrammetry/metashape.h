// SPDX-License-Identifier: GPL-3.0-or-later
// The XML that Agisoft Metashape exports its cameras to.
//
//   sensor/calibration  pixels; u = w / 2 + cx + x' (f + b1) + y' b2, v = h / 2 + cy + y' f, with (0, 0) the corner of
//                       the picture. x' and y' are Brown's with k1 to k4 and p1 to p4, whose p1 and p2 are OpenCV's p2
//                       and p1. A fisheye's are the same of the angle from the axis instead of its tangent. Other
//                       coefficients are refused unless they are 0. A spherical sensor gives full panoramas.
//   camera              label: the photograph's name, with or without its ending, or a path that ends in it. transform:
//                       chunk from camera, 4 x 4 by rows; the camera looks along +z with y down. Cameras that are
//                       disabled or have no pose are left out and counted. Where several photographs have the label,
//                       it is the one in a folder that is called as the camera's group is.
//   master_id           the camera whose transform the whole rig has: chunk from camera is its transform times rotation
//                       (3 x 3 by rows) and location of the camera's own sensor
//   component, chunk    transform: world from chunk, scale * rotation + translation; a camera has that of its
//                       component, else the chunk's, else none
//
// The first chunk with cameras is read.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"

namespace lumatlas {

// Throws InputError that names sensor or camera and value, and what the lookup throws.
[[nodiscard]] Capture parse_metashape(std::string_view text, const std::filesystem::path& path,
                                      const PhotographLookup& photographs);

// The first .xml, by name, that begins as such a file.
[[nodiscard]] std::optional<std::filesystem::path> find_metashape(const std::filesystem::path& scene);
[[nodiscard]] Capture read_metashape(const CaptureRequest& request);

}  // namespace lumatlas
