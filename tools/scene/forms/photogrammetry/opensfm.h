// SPDX-License-Identifier: GPL-3.0-or-later
// OpenSfM's reconstruction.json, which OpenDroneMap keeps in opensfm/.
//
//   [reconstruction]   the one with the most shots is read, and the sizes of the others are told in a note
//   shots              NAME: {camera, rotation, translation}. NAME is the photograph. cam = R X + t, where R turns by
//                      the length of `rotation`, in radians, about its direction, and t is `translation`. The camera
//                      looks along +z with y down
//   rig_instances      rig from world, as the pose of a shot, and rig_camera_ids: a shot's rig camera
//   rig_cameras        camera from rig. A shot without a pose of its own has camera from rig times rig from world
//   cameras            lenses. Lengths are in units of the photograph's longer side s, from its middle:
//                      u = w / 2 + s (c_x + focal_x x'), v = h / 2 + s (c_y + focal_y y'), with (0, 0) the corner of
//                      the picture. `focal` is both focal lengths. In OpenSfM's own pixels the middle of the first
//                      pixel is at (0, 0) and that of the picture at ((w - 1) / 2, (h - 1) / 2): the same place
//
// x' and y' by projection_type, with r the radius in the plane z = 1 and a the angle to the axis:
//
//   perspective, radial, simple_radial   1 + k1 r^2 + k2 r^4
//   brown                                the same with k3 r^6, and OpenCV's p1 and p2
//   fisheye, fisheye_opencv              a (1 + k1 a^2 + k2 a^4 + k3 a^6 + k4 a^8) from the middle
//   fisheye62, fisheye624                the same with k5 a^10 + k6 a^12, p1, p2, and the prism terms s0 a^2 + s1 a^4
//                                        (x) and s2 a^2 + s3 a^4 (y). Read where k5 = k6 = s1 = s3 = 0, or where all of
//                                        p and s are 0; else refused
//   dual                                 read where `transition` is 1 (perspective) or 0 (fisheye); else refused
//   spherical, equirectangular           x = atan2(X, Z) / 2 pi, y = atan2(Y, |X, Z|) / 2 pi, times s: +x is right of
//                                        the middle and +y below it, as in COLMAP's EQUIRECTANGULAR, which is the same
//                                        for a picture that is twice as wide as high; others are refused
//
// A size that is missing or 0 is the photograph's. Shots without a pose are left out and counted. A
// reference_lla that is not at 0 degrees becomes Capture::georeference, and a note tells it. Points are not read.
//
// Source: OpenSfM's documentation ("Reconstruction file format", "Geometric Models") and its opensfm/io.py and
// opensfm/src/geometry/.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"

namespace lumatlas {

// Throws InputError that names file, place and value, and what the lookup throws.
[[nodiscard]] Capture parse_opensfm(std::string_view text, const std::filesystem::path& path,
                                    const PhotographLookup& photographs);

// reconstruction.json in the folder, else in its opensfm/. Photographs are those of the folder `scene` in both cases.
[[nodiscard]] std::optional<std::filesystem::path> find_opensfm(const std::filesystem::path& scene);
[[nodiscard]] Capture read_opensfm(const CaptureRequest& request);

}  // namespace lumatlas
