// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes of no more faces than pictures show: edge collapses by quadric error (Garland and Heckbert 1997), by
// meshoptimizer, and the size of a pixel on the surface, which says how much error pictures do not show.
#pragma once

#include <cstddef>
#include <limits>
#include <span>

#include "mesh/camera/camera.h"
#include "mesh/mesh.h"

namespace lumatlas {

struct SimplificationBound {
  double distance = std::numeric_limits<double>::infinity();  // by which the surface may move, scene units, >= 0
  std::size_t faces = 0;                                      // faces to keep, even if the distance allows fewer
};

struct SimplifiedMesh {
  Mesh mesh;
  double distance = 0;  // by which the surface moved, scene units, as the quadrics estimate it
};

// Collapses the edge that moves the surface least, one after the other, until `bound` is reached. Vertices that are
// left keep their place and colour; boundaries keep their course within the distance. The result is manifold and the
// same for any number of threads. If nothing is collapsed, the result is the mesh itself, with its order of vertices
// and faces. Throws std::invalid_argument if the mesh breaks a rule of mesh.h, or the distance is negative or no
// number.
[[nodiscard]] SimplifiedMesh simplified(const Mesh& mesh, const SimplificationBound& bound);

// Returns the size of a pixel on the surface near the cameras, scene units. For each vertex this is the least
// depth over focal length among the cameras whose picture it lies in, hidden or not. The result is the value below
// which `share` of the vertices, in [0, 1], fall. From at most 20,000 vertices, evenly. Infinite where no camera has a
// vertex in its picture. Throws std::invalid_argument if the mesh, a camera or the share breaks a rule.
[[nodiscard]] double pixel_size(const Mesh& mesh, std::span<const Camera> cameras, double share);

}  // namespace lumatlas
