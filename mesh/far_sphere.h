// SPDX-License-Identifier: GPL-3.0-or-later
// The far sphere: a surface so far behind the scene that it has no parallax between its cameras. Photographs of sky and
// distant surroundings are blended on it.
#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "mesh/camera/camera.h"
#include "mesh/mesh.h"

namespace lumatlas {

// Position and radius of the sphere, scene units.
struct SphereShape {
  glm::dvec3 center{0.0};
  double radius = 0;
};

// Returns the sphere around cameras and a mesh. Its centre is the median of the cameras' centres, axis by axis. Its
// radius is 300 times the distance within which nine tenths of the cameras lie, and at least ten times that of the bulk
// of the mesh. Seen from any two of these cameras, the direction to a point on it differs by less than 0.4 degrees. A
// few cameras and faces far away do not change it. Throws std::invalid_argument for no camera or a mesh without faces.
[[nodiscard]] SphereShape far_sphere_shape(std::span<const Camera> cameras, const Mesh& mesh);

// Returns a triangle mesh of a sphere whose faces are turned towards the centre, from where it is seen. No edge is
// longer than `longest_edge` radii, (0, 1] (std::invalid_argument).
[[nodiscard]] Mesh far_sphere(const SphereShape& shape, double longest_edge);

}  // namespace lumatlas
