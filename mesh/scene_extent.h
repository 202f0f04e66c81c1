// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: the scene's extent where the areas of its faces are known already.
#pragma once

#include <span>

#include "mesh/cells.h"
#include "mesh/face_geometry.h"
#include "mesh/mesh.h"

namespace lumatlas {

// See cells.h. `geometry` holds one per face of a mesh that has been checked.
[[nodiscard]] SceneExtent scene_extent(const Mesh& mesh, std::span<const FaceGeometry> geometry);

}  // namespace lumatlas
