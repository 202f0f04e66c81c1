// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: area and normal of every face, by CGAL. Everything in mesh/ that needs them takes them from here.
// Kept away from the other files because CGAL's kernels compile slowly.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "mesh/mesh.h"

namespace lumatlas {

struct FaceGeometry {
  double area = 0;         // scene units squared
  glm::dvec3 normal{0.0};  // unit; zero where rounding leaves no area
};

[[nodiscard]] std::vector<FaceGeometry> face_geometry(const Mesh& mesh);  // one per face
[[nodiscard]] std::vector<double> face_areas(const Mesh& mesh);           // the same areas alone

}  // namespace lumatlas
