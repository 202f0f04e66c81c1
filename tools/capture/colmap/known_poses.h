// SPDX-License-Identifier: GPL-3.0-or-later
// Poses that are known before COLMAP looks at the photographs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/capture/sources/captured_photographs.h"
#include "tools/scene/forms/colmap/colmap_writer.h"

namespace lumatlas {

struct KnownPoses {
  std::string form;                // the scene's form, such as "Metashape"
  std::vector<WrittenView> views;  // photographs of the capture that have a pose
};

// Reads a scene of any form (tools/scene/forms) and finds its photographs among the captured ones by their names; one
// that was converted has two, its JPEG file's and that of the file before.
// Throws InputError where the scene cannot be read, where fewer than two photographs have a pose, for views of
// panoramas, for a photograph whose pose is that of its upright picture while COLMAP sees it as it is stored, and for a
// lens of which COLMAP has no model.
[[nodiscard]] KnownPoses read_known_poses(const std::filesystem::path& scene, const CapturedPhotographs& captured);

// Writes poses and lenses as a COLMAP model without points into `folder`, in the place of what is there. Images have
// the ids of COLMAP's database, by which its commands find them; those that are not in it are left out, for COLMAP
// could not read them. Throws InputError.
void write_known_poses(const KnownPoses& known, const std::filesystem::path& database,
                       const std::filesystem::path& folder);

}  // namespace lumatlas
