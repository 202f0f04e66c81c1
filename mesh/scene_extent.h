// SPDX-License-Identifier: GPL-3.0-or-later
// The size of a scene: where the bulk of its mesh lies.
#pragma once

#include <span>

#include "mesh/mesh.h"

namespace lumatlas {

// The region that holds the bulk of a mesh.
struct SceneExtent {
  Bounds core;          // along each axis, all but the outermost 1% of the area on each side
  double diameter = 0;  // length of the core's diagonal; > 0 for a mesh with area
};

// Finds where the bulk of a mesh lies. Stray triangles far away do not count, because they have little area. Stray
// vertices do not count either, although their faces may have more area than the scene: faces that are more than a
// hundred times as high as their shortest edge is long, or that lie between two vertices without other faces, are left
// out if they make the box more than twice as large.
[[nodiscard]] SceneExtent scene_extent(const Mesh& mesh);
// Returns the same where the area of each face is known already, of a mesh that passes the rules of mesh.h; neither is
// checked. Takes some 10 bytes a face.
[[nodiscard]] SceneExtent scene_extent(const Mesh& mesh, std::span<const double> areas);
[[nodiscard]] double scene_diameter(const Mesh& mesh);  // the diameter of scene_extent()

}  // namespace lumatlas
