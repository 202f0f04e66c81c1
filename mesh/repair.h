// SPDX-License-Identifier: GPL-3.0-or-later
// From any triangle soup to a manifold mesh, with a count of everything that was changed on the way (CGAL's polygon-soup
// repair; colours follow their vertices).
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "mesh/mesh.h"

namespace lumatlas {

struct RepairReport {
  std::uint64_t non_finite_vertices = 0;     // NaN or infinite: their faces are dropped
  std::uint64_t merged_vertices = 0;         // at exactly the same position as another
  std::uint64_t isolated_vertices = 0;       // used by no face
  std::uint64_t degenerate_faces = 0;        // two equal corners, or collinear ones
  std::uint64_t duplicate_faces = 0;         // the same three vertices as another, in any order
  std::uint64_t non_manifold_edges = 0;      // shared by three faces or more, split
  std::uint64_t non_manifold_vertices = 0;   // whose faces do not form one fan, split
  std::uint64_t reversed_faces = 0;          // turned round to agree with their neighbours
  [[nodiscard]] bool changed_anything() const;
};

struct RepairedMesh {
  Mesh mesh;
  RepairReport report;
};

// `offset` is subtracted from every position in double precision before it becomes a float.
// Within a connected component the orientation that most of its faces had is kept.
// Throws InputError if no face is left.
[[nodiscard]] RepairedMesh repair(const TriangleSoup& soup, const glm::dvec3& offset);

}  // namespace lumatlas
