// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/tables/view_table.h"

#include <glm/glm.hpp>
#include <string>

#include "blend/gl/egl_context.h"

namespace lumatlas {

namespace {

glm::dvec3 row_of(const glm::dmat3& matrix, int row) {
  return {matrix[0][row], matrix[1][row], matrix[2][row]};
}

}  // namespace

std::vector<glm::vec4> view_table(const Snapshot& snapshot, const ArrayContents& photographs) {
  std::vector<glm::vec4> table(kViewTexels * snapshot.views.size(), glm::vec4(0));
  for (ViewSlot slot{0}; slot < snapshot.views.size(); ++slot) {
    if (!snapshot.views[slot]) continue;
    const Camera& camera = snapshot.views[slot]->camera;
    if (photographs.first_tile[slot] > kMostTiles) {
      throw GlError("the model's views have more than " + std::to_string(kMostTiles) +
                    " tiles: build it with fewer (--max-views) or with larger tiles");
    }
    glm::vec4* texel = &table[kViewTexels * slot];
    const glm::dmat3& rotation = camera.cam_from_world_rotation;
    texel[0] = glm::dvec4(camera.fx * row_of(rotation, 0), camera.cx);
    texel[1] = glm::dvec4(camera.fy * row_of(rotation, 1), camera.cy);
    texel[2] = glm::dvec4(row_of(rotation, 2), camera.fx);
    texel[3] = glm::dvec4(camera.center(), photographs.scaled[slot].scale);
    texel[4] = glm::vec4(camera.width, camera.height, photographs.first_tile[slot],
                         photographs.columns_of(*snapshot.views[slot]));
    texel[5] = glm::dvec4(snapshot.gains[slot], 0);
  }
  return table;
}

}  // namespace lumatlas
