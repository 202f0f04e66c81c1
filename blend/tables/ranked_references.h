// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: orders the references of each zone by the most that they can weigh in a picture, so that a pixel
// looks at the first few and stops. The pixel's result is that of all references: see find_views() of
// shaders/blend.frag. The page does the same: tools/viewer/page/drawing/ranked_references.js.
//
// A zone lies in a ball of centre C and radius r. With the angle t at C between the directions to the two cameras, at
// distances o and i, for every point of the ball
//
//   angle >= t - asin(r / o) - asin(r / i)
//   min(o', i') / max(o', i') <= (min(o, i) + r) / (max(o, i) - r)
//
// and both bound the weight from above (blend_options.h). Inside of the ball a camera bounds nothing.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "blend/blend_options.h"
#include "blend/tables/zone_mesh.h"
#include "mesh/camera/camera.h"

namespace lumatlas {

// In world coordinates, scene units.
struct Ball {
  glm::dvec3 center{0.0};
  double radius = -1;  // below 0: empty
};

// Returns a ball around the faces of each combination of cells.
[[nodiscard]] std::vector<Ball> balls_of_combinations(const ChunkMesh& mesh);

// Returns the least upper bound that is known for geometric_weight() in the ball, and a little more, because the shader
// rounds. In [0, 1.001].
[[nodiscard]] double bound_of_weight(const Ball& ball, const glm::dvec3& novel_center, const glm::dvec3& stored_center,
                                     const BlendOptions& options);

// A reference as shaders/tables.glsl reads it: view slot and cells, and the bits of its bound as a float.
using RankedReference = glm::uvec2;

// Returns the references in the order of `lists`, each with a bound above every weight.
[[nodiscard]] std::vector<RankedReference> unranked(const ZoneReferences& lists);

// Sorts the references of each zone that the camera can see by their bounds, the largest first. Others keep their
// order and may have any bound. `balls`: one for each range of `lists`; `stored_centers`: by view slot, none where
// there is no view.
void rank_references(const ZoneReferences& lists, std::span<const Ball> balls, const Camera& camera,
                     std::span<const std::optional<glm::dvec3>> stored_centers, const BlendOptions& options,
                     std::span<RankedReference> references);

}  // namespace lumatlas
