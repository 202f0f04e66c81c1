// SPDX-License-Identifier: GPL-3.0-or-later
// Polycam's raw export.
//
//   keyframes/corrected_cameras/ID.json  or cameras/ID.json where there is none, which is told in a note: fx fy cx cy
//                                        width height in pixels, (0, 0) the corner of the picture; t_00 ... t_23 world
//                                        from camera by rows, of ARKit's camera: x right, y up, z backward
//   keyframes/corrected_images/ID.jpg    or images/ID.jpg, for those cameras. The first have a black rim where the
//                                        undistortion found nothing, which is masked out
//   keyframes/depth/ID.png               depth images in millimetres, smaller, of what the photograph shows
//   keyframes/confidence/ID.png          of the depth's size: 0 low, 127 medium, 255 high. What is 0 is left out
//   mesh_info.json alignmentTransform    mesh from world, 4 x 4 by columns, a rotation and a translation. It is
//                                        applied, so that poses are in the coordinates of raw.glb
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

struct PolycamFiles {
  std::filesystem::path cameras;                            // the folder, for sentences
  std::vector<std::pair<std::string, std::string>> frames;  // each camera's ID and its JSON
  std::filesystem::path mesh_info;                          // for sentences
  std::optional<std::string> mesh_info_text;
  std::set<std::string> depths = {};       // the IDs of those in keyframes/depth/
  std::set<std::string> confidences = {};  // the IDs of those in keyframes/confidence/
};

// `photograph_of` gives name and file of a camera's ID. Throws InputError that names file and place.
[[nodiscard]] Capture parse_polycam(const PolycamFiles& files,
                                    const std::function<PosedPhotograph(const std::string&)>& photograph_of);

// The folder of cameras, if there is one.
[[nodiscard]] std::optional<std::filesystem::path> find_polycam(const std::filesystem::path& scene);
[[nodiscard]] Capture read_polycam(const CaptureRequest& request);

}  // namespace lumatlas
