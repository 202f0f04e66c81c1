// SPDX-License-Identifier: GPL-3.0-or-later
// Triangle meshes: the soup that a file holds, and the repaired mesh that everything else works on.
#pragma once

#include <cstdint>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace lumatlas {

// The triangles of a mesh file, in the file's own coordinates, which may be far from the origin.
struct TriangleSoup {
  std::vector<glm::dvec3> positions;
  std::vector<glm::u8vec3> colors;  // sRGB, one per position, or empty
  std::vector<glm::uvec3> faces;    // indices into positions, each valid
};

// A manifold triangle mesh, consistently oriented per component, without degenerate faces or isolated vertices, as
// repair() makes it. It may have boundary and many components. Positions are relative to the scene's offset.
struct Mesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::u8vec3> colors;  // sRGB, one per position, or empty
  std::vector<glm::uvec3> faces;
};

// Throws std::invalid_argument naming the entry, its value and the rule, for a mesh that no function can work with: a
// face that refers to no vertex, colours that are neither none nor one per position, a position that is not finite, or
// more than 5e8 faces or vertices. Whether a mesh is manifold takes longer to find out and is not checked here: every
// function says how it treats other meshes. All functions of mesh/ that take a mesh call this first.
void check(const Mesh& mesh);
// Checks the first of these rules alone, for functions that take any coordinates.
void check_faces(const Mesh& mesh);

// Axis-aligned bounds. Without points, `min` is above `max`.
struct Bounds {
  glm::dvec3 min{1.0};
  glm::dvec3 max{-1.0};
  [[nodiscard]] bool empty() const { return min.x > max.x; }
};
// Return the smallest box around a box and a point, or two boxes.
[[nodiscard]] Bounds with(const Bounds& box, const glm::dvec3& point);
[[nodiscard]] Bounds with(const Bounds& box, const Bounds& other);
// Return the box of the positions that faces use. Throw std::invalid_argument for a face that refers to no vertex.
[[nodiscard]] Bounds bounds(const TriangleSoup& soup);
[[nodiscard]] Bounds bounds(const Mesh& mesh);

}  // namespace lumatlas
