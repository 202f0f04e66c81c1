// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: makes a triangle list an oriented manifold. Memory beside the list itself follows from the defects
// and from the number of vertices; CGAL's functions for polygon soups take some 200 bytes a face instead.
// Source: Gueziec et al., "Cutting and Stitching: Converting Sets of Polygons to Manifold Surfaces", 2001.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "mesh/vertex_faces.h"

namespace lumatlas {

using TriangleList = std::vector<std::array<std::uint32_t, 3>>;

// Drops every face that has the same three vertices as an earlier one, in any order; the others keep theirs. Returns
// how many were dropped. `suspects`: vertices_without_one_fan().
[[nodiscard]] std::size_t drop_duplicate_faces(TriangleList& faces, const VertexFaces& around,
                                               const std::vector<std::uint32_t>& suspects);

// Returns the faces that drop_duplicate_faces() drops, ascending.
[[nodiscard]] std::vector<std::uint32_t> duplicate_faces(const TriangleList& faces, const VertexFaces& around,
                                                         const std::vector<std::uint32_t>& suspects);

struct SplitVertices {
  std::uint64_t vertices = 0;  // that got copies
  // The vertices that the new numbers stand for, which the faces refer to after those that were there: of each split
  // vertex one for each of its fans but the first.
  std::vector<std::uint32_t> copies;
};

// Gives each fan of faces around a suspect a vertex of its own.
[[nodiscard]] SplitVertices split_vertices(std::size_t vertices, TriangleList& faces, const VertexFaces& around,
                                           const std::vector<std::uint32_t>& suspects);

struct OrientedFaces {
  std::uint64_t non_manifold_edges = 0;  // with three faces or more
  std::uint64_t reversed_faces = 0;      // turned round to agree with their neighbours
  std::uint64_t split_vertices = 0;      // that got copies
  std::vector<std::uint32_t> copies;     // see SplitVertices
};

// Turns round the faces that turn against most of their connected component, whose first face decides where both are as
// many, and gives each fan of faces around a vertex a vertex of its own. Faces are connected over edges that have two
// faces. A one-sided component is cut along edges whose faces turned against each other as given. No two faces may have
// the same three vertices. `suspects`: vertices_without_one_fan().
[[nodiscard]] OrientedFaces orient_and_split(std::size_t vertices, TriangleList& faces, const VertexFaces& around,
                                             const std::vector<std::uint32_t>& suspects);

}  // namespace lumatlas
