// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/mesh.h"

#include <glm/common.hpp>

namespace lumatlas {

namespace {

template <typename Positions>
Bounds bounds_of(const Positions& positions, const std::vector<glm::uvec3>& faces) {
  Bounds box;
  if (faces.empty()) return box;
  box.min = box.max = glm::dvec3(positions[faces[0].x]);
  for (const glm::uvec3& face : faces) {
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 position(positions[face[corner]]);
      box.min = glm::min(box.min, position);
      box.max = glm::max(box.max, position);
    }
  }
  return box;
}

}  // namespace

Bounds bounds(const TriangleSoup& soup) {
  return bounds_of(soup.positions, soup.faces);
}
Bounds bounds(const Mesh& mesh) {
  return bounds_of(mesh.positions, mesh.faces);
}

}  // namespace lumatlas
