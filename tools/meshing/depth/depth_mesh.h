// SPDX-License-Identifier: GPL-3.0-or-later
// From a scene's depth images to its mesh.
#pragma once

#include "tools/meshing/scene_mesh.h"

namespace lumatlas {

// `scene` has depth images; its poses are in its own coordinates. Holes stay open. The same mesh for any number of
// threads. Throws InputError naming the depth image that cannot be used, also where they contradict each other so much
// that their unit or the poses must be wrong, unless options.depth_unit says which it is.
[[nodiscard]] SceneMesh mesh_from_depths(SceneViews scene, const SceneMeshOptions& options,
                                         const StageProgress& progress);

}  // namespace lumatlas
