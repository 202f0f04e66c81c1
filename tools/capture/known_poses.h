// SPDX-License-Identifier: GPL-3.0-or-later
// Poses that are known before COLMAP looks at the photographs.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/capture/captured_photographs.h"

namespace lumatlas {

struct KnownPoses {
  std::string form;                  // of the scene, such as "Metashape"
  std::size_t posed = 0;             // photographs of the capture that have a pose
  std::vector<std::string> missing;  // the others, by name
};

// Reads a scene of any form (tools/scene/forms), finds its photographs among the captured ones by their names, and
// writes their poses and lenses as a COLMAP model without points into `folder`, which is made.
// Throws InputError where the scene cannot be read, where fewer than two photographs have a pose, for views of
// panoramas, for a photograph whose pose is that of its upright picture while COLMAP sees it as it is stored, and for a
// lens of which COLMAP has no model.
[[nodiscard]] KnownPoses write_known_poses(const std::filesystem::path& scene, const CapturedPhotographs& captured,
                                           const std::filesystem::path& folder);

}  // namespace lumatlas
