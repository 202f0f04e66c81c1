// SPDX-License-Identifier: GPL-3.0-or-later
// Triangle meshes: the soup that a file holds, and the repaired mesh that everything else works on.
#pragma once

#include <cstdint>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace lumatlas {

// What a mesh file says: any triangles, in the file's own coordinates, which may be far from the origin.
struct TriangleSoup {
  std::vector<glm::dvec3> positions;
  std::vector<glm::u8vec3> colors;  // sRGB, one per position, or empty
  std::vector<glm::uvec3> faces;    // indices into positions, each valid
};

// A manifold triangle mesh, consistently oriented per component, without degenerate faces or isolated vertices.
// It may have boundary and many components. Positions are relative to the scene's offset.
struct Mesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::u8vec3> colors;  // sRGB, one per position, or empty
  std::vector<glm::uvec3> faces;
};

// Axis-aligned bounds; `min` is above `max` for no points at all.
struct Bounds {
  glm::dvec3 min{1.0};
  glm::dvec3 max{-1.0};
  [[nodiscard]] bool empty() const { return min.x > max.x; }
};
[[nodiscard]] Bounds bounds(const TriangleSoup& soup);  // of the positions that faces use
[[nodiscard]] Bounds bounds(const Mesh& mesh);

}  // namespace lumatlas
