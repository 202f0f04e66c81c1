// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: the scene's extent where the areas of its faces are known already.
#pragma once

#include <span>

#include "mesh/cells/cells.h"
#include "mesh/mesh.h"

namespace lumatlas {

// See cells.h. `areas` holds that of each face of a mesh that has been checked. Takes some 10 bytes a face.
[[nodiscard]] SceneExtent scene_extent(const Mesh& mesh, std::span<const double> areas);

}  // namespace lumatlas
