// SPDX-License-Identifier: GPL-3.0-or-later
// Makes a manifold mesh of any triangle soup, with a count of everything that was changed on the way. Colours follow
// their vertices. Memory beside soup and mesh is some 50 bytes a face, with defects as without.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "mesh/cancel_check.h"
#include "mesh/mesh.h"

namespace lumatlas {

// Exact counts, in the order of the work: each step sees what the steps before it left.
struct RepairReport {
  std::uint64_t non_finite_vertices = 0;    // NaN or infinite, also after the offset and as a float: dropped
  std::uint64_t non_finite_faces = 0;       // that had such a corner: dropped
  std::uint64_t merged_vertices = 0;        // at exactly the same position (less offset, as a float) as an earlier one
  std::uint64_t degenerate_faces = 0;       // two equal corners, or collinear ones: dropped
  std::uint64_t duplicate_faces = 0;        // the same three vertices as an earlier one, in any order: dropped
  std::uint64_t isolated_vertices = 0;      // used by no face that is left: dropped
  std::uint64_t non_manifold_edges = 0;     // shared by three faces or more: each of them gets an edge of its own
  std::uint64_t non_manifold_vertices = 0;  // whose faces do not form one fan (the ends of non-manifold edges, and
                                            // where a one-sided surface had to be cut, among them): one copy per fan
  std::uint64_t reversed_faces = 0;         // turned round to agree with their neighbours

  bool operator==(const RepairReport&) const = default;
};

struct RepairedMesh {
  Mesh mesh;
  RepairReport report;
};

// `offset` is subtracted from every position in double precision before it becomes a float. Within a connected
// component the orientation that most of its faces had is kept; a one-sided one is cut along edges at which its faces
// turned against each other. A merged vertex has the colour of the first. Faces keep their order. A soup that needs no
// repair keeps the order of its vertices and faces. Throws InputError if no face is left, std::invalid_argument if the
// soup breaks its own rules (mesh.h: colours, and faces that refer to no position), has more than 5e8 faces or
// positions, or the offset is not finite. `cancel_check` is called between the steps; a step takes less than a second
// for a million faces.
[[nodiscard]] RepairedMesh repair(const TriangleSoup& soup, const glm::dvec3& offset,
                                  const CancelCheck& cancel_check = {});

}  // namespace lumatlas
