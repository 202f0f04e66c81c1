// SPDX-License-Identifier: GPL-3.0-or-later
// The transforms.json of instant-ngp and nerfstudio, which Polycam, Record3D and others export to.
//
//   frames[].transform_matrix  world from camera, 4 x 4 by rows, of OpenGL's camera: x right, y up, z backward. The
//                              last row may be missing.
//   frames[].file_path         relative to the file's folder; the ending may be missing
//   frames[].mask_path         the same, black where pixels are not to be used
//   frames[].depth_file_path   the same, 16-bit, 0 where nothing was measured; it shows what the photograph shows
//   depth_unit_scale_factor    units that one of its steps is, of all frames or of one; 0.001 where there is none, as
//                              in nerfstudio; applied_scale multiplies it, as it did the poses
//   w h fl_x fl_y cx cy        pixels, (0, 0) is the corner of the picture as in COLMAP; of all frames or of one
//   camera_angle_x             the horizontal field of view in radians, where there is no fl_x
//   camera_model               SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL and OPENCV, which are one, FULL_OPENCV,
//                              OPENCV_FISHEYE; others are refused. is_fisheye is OPENCV_FISHEYE
//   k1 k2 k3 k4 p1 p2          as nerfstudio has them: k1 to k4 before r^2 to r^8, of a fisheye of the angle; of
//                              FULL_OPENCV as OpenCV has them, with k5 and k6
//   ply_file_path              points, in the coordinates of the poses
//
// Missing values have the usual defaults: fl_y is fl_x, the principal point is the middle, w and h are the
// photograph's. applied_transform, which led to these poses, is not undone: a mesh is in the coordinates of the poses,
// as the points are. A coefficient of another lens is refused unless it is 0. Keys that are not known are told in a
// note.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string_view>

#include "atlas/images/photograph.h"
#include "tools/scene/forms/capture.h"

namespace lumatlas {

// The questions that parse_transforms() asks about files, so that it opens none itself.
struct TransformsLookup {
  // The path of a file with its ending, of one that may lack it.
  std::function<std::filesystem::path(const std::filesystem::path& file)> complete;
  // Returns the size of the photograph, which has its name and file, where w or h are missing.
  std::function<ImageSize(const PosedPhotograph&)> size_of;
  BadPhotographs bad = BadPhotographs::refuse;
};

// Photographs keep paths that lead out of the folder, with '/' between folders: see find_photographs(). Throws
// InputError that begins with `path`, and what `lookup` throws.
[[nodiscard]] Capture parse_transforms(std::string_view text, const std::filesystem::path& path,
                                       const TransformsLookup& lookup);

// transforms.json in the folder `scene`, else Blender's transforms_train.json, if there is one.
[[nodiscard]] std::optional<std::filesystem::path> find_transforms(const std::filesystem::path& scene);
// Photographs are looked at for their endings, and for their sizes in `images` if it is given. In Blender's captures
// the photographs of transforms_test.json, or without it of transforms_val.json, are held out.
[[nodiscard]] Capture read_transforms(const CaptureRequest& request);

}  // namespace lumatlas
