// SPDX-License-Identifier: GPL-3.0-or-later
// The cameras of Meshroom (AliceVision): cameras.sfm, or another .sfm or .json, of version 1. Numbers may be texts.
//
//   views        path: the photograph. Those without a pose or a lens, or with a pose that is only a rotation, are left
//                out and counted
//   poses        poseId; pose.transform: cam = R (X - center), z forward with y down; `rotation` is R by columns
//   rigs         rigId; subPoses. A view whose isPoseIndependant is false has the pose subPoses[subPoseId] (camera from
//                rig) times that of its poseId (rig from world), as AliceVision has it; other views have that of their
//                poseId alone
//   intrinsics   pixels, with (0, 0) the corner of the picture, are
//
//     before 1.2.0   fx = fy = pxFocalLength
//     1.2.0, 1.2.1   fx, fy = pxFocalLength
//     from 1.2.2     F = width * focalLength / sensorWidth (36 where there is none), and r = pixelRatio: fx = F with
//                    fy = F / r before 1.2.5 and fy = F r until 1.2.8; fx = F / r with fy = F from 1.2.11 on. Versions
//                    1.2.9 and 1.2.10 are refused unless r is 1, because it is not known which rule they follow
//     before 1.2.1   cx, cy = principalPoint
//     from 1.2.1     cx, cy = (width / 2, height / 2) + principalPoint
//
// The lens is that of `type`, or of `distortionType` where a newer file has one for the type pinhole. Coefficients are
// distortionParams, in the plane z = 1:
//
//   pinhole, none           none
//   radial1, radialk1       k1
//   radial3, radialk3       k1, k2, k3
//   brown                   k1, k2, k3 and OpenCV's p1 and p2
//   fisheye4, fisheye       OpenCV's k1 to k4 of the angle to the axis
//   fisheye1                k1: omega of FOV, which must not be negative
//   equirectangular         none; COLMAP's EQUIRECTANGULAR, as +x is right of the middle and +y below it. Refused
//                           unless focal lengths and principal point are those of the whole sphere
//
// Other lenses, such as equidistant, radialk3pt and those of 3DEqualizer, are refused, and so is an undistortion. As
// AliceVision's exporter to COLMAP does, the principal point is taken as it is, though its features have the middle of
// the first pixel at (0, 0).
//
// Source: AliceVision, src/aliceVision/sfmDataIO/jsonIO.cpp, jsonIO.hpp and CHANGES.md, and src/aliceVision/camera/.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"

namespace lumatlas {

// Throws InputError that names file, place and value, and what the lookup throws.
[[nodiscard]] Capture parse_meshroom(std::string_view text, const std::filesystem::path& path,
                                     const PhotographLookup& photographs);

// cameras.sfm, else the first .sfm, else the first .json, by name, that begins as such a file.
[[nodiscard]] std::optional<std::filesystem::path> find_meshroom(const std::filesystem::path& scene);
[[nodiscard]] Capture read_meshroom(const CaptureRequest& request);

}  // namespace lumatlas
