// SPDX-License-Identifier: GPL-3.0-or-later
// VisualSFM's N-view match, .nvm, of version 3.
//
//   first line  NVM_V3, optionally with "FixedK fx cx fy cy", the calibration of all cameras, in pixels
//   models      of each the count of its cameras and a line for each, then the count of its points and these; a count
//               of 0 cameras ends them
//   camera      file, focal length in pixels, quaternion w x y z of camera from world, camera centre, radial term r, 0;
//               the camera looks along +z with y down. A blank in the file's name is written as '"'
//   lens        r runs from the photograph to the ideal picture: with m from the middle of the photograph in units of
//               the focal length, the camera sees (m (1 + r m^2), 1)
//
// No lens model has this inverse exactly: FULL_OPENCV's ratio of polynomials is fitted to it over the photograph, and a
// photograph in which the fit is off by more than 0.1 pixels is refused. The model with the most cameras is read if
// there are several, and a note says so. A model without points after one with points lists photographs without a pose:
// they are left out and counted. The size of photographs is not stated: measured_size.h says what is assumed.
//
// Source: Wu, "VisualSFM: A Visual Structure from Motion System", its documentation, section "NVM file format".
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"

namespace lumatlas {

// Throws InputError that names the line, and what the lookup throws. Allocates no more than a small multiple of the
// bytes that it is given. Where bad photographs are kept, these are the ones with a pose or a lens that cannot be.
[[nodiscard]] Capture parse_visual_sfm(std::string_view text, const std::filesystem::path& path,
                                       const PhotographLookup& photographs);

// The first .nvm file, by name, that begins with NVM_V.
[[nodiscard]] std::optional<std::filesystem::path> find_visual_sfm(const std::filesystem::path& scene);
[[nodiscard]] Capture read_visual_sfm(const CaptureRequest& request);

}  // namespace lumatlas
