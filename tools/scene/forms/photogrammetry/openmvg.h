// SPDX-License-Identifier: GPL-3.0-or-later
// OpenMVG's sfm_data.json, versions 0.1 to 0.3. Its binary form, sfm_data.bin, is not read.
//
//   views        value.ptr_wrapper.data: filename in local_path in root_path is the photograph; id_pose and
//                id_intrinsic are keys of the next two. Views that lack either of these are left out and counted
//   extrinsics   rotation (3 x 3 by rows) and center: cam = rotation (X - center), z forward with y down
//   intrinsics   polymorphic_name says the lens; its numbers are in ptr_wrapper.data, in pixels:
//
//     pinhole             focal_length, principal_point
//     pinhole_radial_k1   and disto_k1: k1
//     pinhole_radial_k3   and disto_k3: k1, k2, k3
//     pinhole_brown_t2    and disto_t2: k1, k2, k3 and OpenCV's p1 and p2
//     fisheye             and fisheye: OpenCV's k1 to k4 of the angle to the axis
//     spherical           a panorama of the whole sphere, COLMAP's EQUIRECTANGULAR: right is +x, down is +y
//
// Other lenses are refused. The principal point is taken to be from the corner of the picture, so that (w / 2, h / 2)
// is its middle: that is where OpenMVG starts, and what its exporter to COLMAP writes unchanged. OpenMVG's features and
// undistortion have the middle of the first pixel at (0, 0), so a principal point that was refined may lie half a pixel
// further. Earlier versions of OpenMVG had +y of a spherical camera up; a note says what is assumed.
//
// The writer is cereal: a type's polymorphic_name stands at its first polymorphic_id, an object's data at its first id.
//
// Source: OpenMVG, src/openMVG/sfm/sfm_data_io_cereal.cpp, sfm_view_io.hpp and src/openMVG/cameras/.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"

namespace lumatlas {

// Throws InputError that names file, place and value, and what the lookup throws.
[[nodiscard]] Capture parse_openmvg(std::string_view text, const std::filesystem::path& path,
                                    const PhotographLookup& photographs);

// sfm_data.json, else the first .json, by name, that begins as such a file.
[[nodiscard]] std::optional<std::filesystem::path> find_openmvg(const std::filesystem::path& scene);
[[nodiscard]] Capture read_openmvg(const CaptureRequest& request);

}  // namespace lumatlas
