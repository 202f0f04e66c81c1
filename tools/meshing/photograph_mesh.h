// SPDX-License-Identifier: GPL-3.0-or-later
// From a scene's photographs to its mesh.
#pragma once

#include <functional>

#include "tools/meshing/scene_mesh.h"
#include "tools/stereo/scene_stereo.h"

namespace lumatlas {

inline constexpr const char* kMatchingStage = "matching photographs";  // which takes nearly all of the time

// `scene` and `points` (which may be none) are in the scene's own coordinates. The photographs' depths are found by
// tools/stereo and become a surface like those of depth images. The same mesh for any number of threads. `matched`, if
// given, is called with the depths before they become a surface; what it throws ends the work. Throws InputError, also
// where the photographs show too little of the same.
[[nodiscard]] SceneMesh mesh_from_photographs(SceneViews scene, ScenePoints points, const SceneMeshOptions& options,
                                              const StageProgress& progress,
                                              const std::function<void(const SceneStereo&)>& matched = {});

}  // namespace lumatlas
