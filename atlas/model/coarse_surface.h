// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: a model's surface in few faces, which is shown until the whole one is there.
#pragma once

#include <cstddef>
#include <glm/gtc/type_precision.hpp>
#include <span>

#include "mesh/mesh.h"

namespace lumatlas {

struct CoarseSurface {
  Mesh mesh;         // with colours; empty: the surface needs none
  double error = 0;  // distance by which the surface moved, as quadrics estimate it, scene units
};

// Returns the mesh with its vertex colours (one per vertex, sRGB) in about `faces` faces. More faces stay where fewer
// would close its holes. Empty where the mesh has at most twice as many. The same bytes for the same input.
[[nodiscard]] CoarseSurface coarse_surface(const Mesh& mesh, std::span<const glm::u8vec3> colors, std::size_t faces);

}  // namespace lumatlas
