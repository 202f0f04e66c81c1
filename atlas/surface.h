// SPDX-License-Identifier: GPL-3.0-or-later
// The geometry that a view store belongs to: a mesh and its cells.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

#include "mesh/cells/cells.h"
#include "mesh/mesh.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

struct Surface {
  Mesh mesh;
  Cells cells;
  glm::dvec3 offset{0.0};  // subtracted from the input's coordinates, scene units
  // Numbers of faces, vertices and cells of the far sphere (mesh/far_sphere.h), which are the last ones. It shows what
  // photographs show where they see no other face, and is drawn as if it were infinitely far. It shares no vertex with
  // the other faces.
  std::uint32_t far_faces = 0, far_vertices = 0, far_cells = 0;

  [[nodiscard]] std::size_t near_faces() const { return mesh.faces.size() - far_faces; }
  [[nodiscard]] std::size_t near_cells() const { return cells.cells.size() - far_cells; }
};

// Throws std::invalid_argument, naming the first face or table that breaks a rule. Every corner of a face must be a
// vertex, the mesh must have a colour for each vertex or none at all, cell_of_face must name an existing cell for each
// face, and no face or cell may be both near and far.
void check(const Surface& surface);

// Returns the surface without its far sphere. Use it for the extent of the scene and for textures.
[[nodiscard]] Surface near_surface(const Surface& surface);

// A far sphere and its cells; empty where there is none.
struct FarSphere {
  Mesh mesh;
  Cells cells;
};
[[nodiscard]] FarSphere far_sphere_of(const Surface& surface);

// The surface with this far sphere in the place of its own. Where the surface has colours, those of the sphere are
// black until photographs give them others.
[[nodiscard]] Surface with_far_sphere(const Surface& surface, const FarSphere& far);

// A depth between those of the near surface and those of the far sphere, for any camera of the scene; infinite where
// there is no far sphere.
[[nodiscard]] float depth_before_far(const Surface& surface);

// Makes the pixels that see the far sphere empty.
void leave_out_far(const Surface& surface, VisibilityBuffer& visible);

}  // namespace lumatlas
