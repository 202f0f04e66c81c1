// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: a model's surface in few faces, which is shown until the whole one is there.
#pragma once

#include <cstddef>

#include "mesh/mesh.h"

namespace lumatlas {

struct CoarseSurface {
  Mesh mesh;         // with colours
  double error = 0;  // distance by which the surface moved, as quadrics estimate it, scene units
};

// Returns the geometric error of 3D Tiles, scene units, 0 without a surface: how coarse this looks. Clients show a tile
// until its error is some 16 pixels, as with textures whose texels are then a pixel apart. Colours stand at vertices
// here, so that the error is 16 times their usual distance, or what the surface moved if that is more.
[[nodiscard]] double geometric_error(const CoarseSurface& coarse);

// Returns whether a surface of `faces` faces needs a coarse surface: whether it has more than twice `coarse_faces`. It
// needs none where `coarse_faces` is 0.
[[nodiscard]] bool needs_coarse_surface(std::size_t faces, std::size_t coarse_faces);

// The source of a coarse surface: a surface, or coarse surfaces side by side, whose borders do not meet exactly.
enum class CoarseSource { surface, coarse_surfaces };

// Returns the mesh with its vertex colours (one per vertex, sRGB) in about `faces` faces. More faces stay where fewer
// would close the holes of a surface. The same bytes for the same input.
[[nodiscard]] CoarseSurface coarse_surface(const Mesh& mesh, std::size_t faces,
                                           CoarseSource source = CoarseSource::surface);

}  // namespace lumatlas
