// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/city/: the sizes that a city's plan decides once, and its views.
#pragma once

#include <algorithm>
#include <cstddef>

#include "mesh/cells/cells.h"
#include "tools/city/city_plan.h"
#include "tools/city/planning/block_cut.h"
#include "tools/scene/scene.h"

namespace lumatlas {

// Returns the size that cells of a city have. `build` divides a scene by its diameter, but a city is larger than what
// any photograph shows, so that the usual distance of the cameras bounds the size too.
[[nodiscard]] inline double city_cell_size(const Mesh& mesh, double usual_distance) {
  constexpr double kShareOfDistance = 0.085;  // 1/60 of the diameter of a village seen from the air
  return std::min(automatic_cell_size(mesh), kShareOfDistance * usual_distance);
}

// Returns how many faces the chunks of a plan's surface have at most.
[[nodiscard]] inline std::size_t chunk_faces_for(std::size_t block_faces) {
  return std::max<std::size_t>(1, block_faces / kChunksPerBlock);
}

// Returns the view as it was given.
[[nodiscard]] inline CityView city_view(const SceneView& view) {
  return {view.name, view.camera, view.correction, view.motion, glm::dvec3(1.0), view.black_rim};
}

}  // namespace lumatlas
