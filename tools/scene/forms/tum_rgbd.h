// SPDX-License-Identifier: GPL-3.0-or-later
// The folders of the TUM RGB-D benchmark, which other trajectories are written as too.
//
//   rgb.txt          timestamp file, seconds
//   groundtruth.txt  timestamp tx ty tz qx qy qz qw: world from camera, which looks along +z with y down
//   depth.txt        as rgb.txt, of 16-bit PNG files, 5000 steps to a metre, as the photographs' lens sees it
//   camera.txt       fx fy cx cy, or with k1 k2 p1 p2, or with k3 too, as OpenCV has them: pixels, the middle of the
//                    first pixel at (0, 0). TUM's folders have none
//
// A photograph or a depth image gets the pose nearest in time, at most 20 ms away: none is interpolated. Without
// camera.txt, a folder whose name has freiburg1, freiburg2 or freiburg3 in it gets the calibration that TUM published
// for that camera.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "tools/scene/forms/capture.h"

namespace lumatlas {

struct TumFiles {
  std::filesystem::path folder;  // its name may say which camera it was; the files' names follow it in sentences
  std::string rgb, groundtruth;  // the contents
  std::optional<std::string> camera = {}, depth = {};
};

// Throws InputError that names file and line, and what size_of throws.
[[nodiscard]] Capture parse_tum(const TumFiles& files, const std::function<ImageSize(const PosedPhotograph&)>& size_of);

// groundtruth.txt, if the folder is one of these.
[[nodiscard]] std::optional<std::filesystem::path> find_tum(const std::filesystem::path& scene);
[[nodiscard]] Capture read_tum(const CaptureRequest& request);

}  // namespace lumatlas
