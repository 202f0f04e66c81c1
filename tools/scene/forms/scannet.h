// SPDX-License-Identifier: GPL-3.0-or-later
// ScanNet's exported folders.
//
//   color/N.jpg                    the photographs
//   pose/N.txt                     world from camera, 4 x 4 by rows; the camera looks along +z with y down. Where
//                                  tracking was lost it is all -inf: such photographs are left out and counted
//   depth/N.png                    depth images in millimetres, taken to be from the photographs' poses
//   intrinsic/intrinsic_depth.txt  as intrinsic_color.txt, of depth images; without it they have the photographs' lens
//   intrinsic/intrinsic_color.txt  fx, fy, cx and cy in a 4 x 4, pixels, the middle of the first pixel at (0, 0)
//
// A mesh, such as ScanNet's NAME_vh_clean_2.ply, is in the same coordinates.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tools/scene/forms/capture.h"

namespace lumatlas {

struct ScanNetDepths {
  std::set<std::string> stems;           // N of each depth/N.png
  std::optional<std::string> intrinsic;  // the contents
  ImageSize size;                        // the size of one of them
};

struct ScanNetFiles {
  std::filesystem::path folder;                            // for sentences
  std::string intrinsic;                                   // the contents
  std::vector<std::pair<std::string, std::string>> poses;  // each photograph's name in color/ and its pose's text
  std::optional<ScanNetDepths> depths = {};
};

// Throws InputError that names the file, and what size_of throws.
[[nodiscard]] Capture parse_scannet(const ScanNetFiles& files,
                                    const std::function<ImageSize(const PosedPhotograph&)>& size_of);

// intrinsic/intrinsic_color.txt, if the folder is one of these.
[[nodiscard]] std::optional<std::filesystem::path> find_scannet(const std::filesystem::path& scene);
[[nodiscard]] Capture read_scannet(const CaptureRequest& request);

}  // namespace lumatlas
