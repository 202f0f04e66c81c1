// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: OpenMesh's halfedge mesh, over which clusters grow and in which long edges are split. Slow to
// compile: include it in few places.
#pragma once

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include "mesh/mesh.h"

namespace lumatlas {

struct InterpolatingTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3f;
  using Color = OpenMesh::Vec3f;  // sRGB in [0, 255], not rounded, so that repeated interpolation does not drift
  VertexAttributes(OpenMesh::Attributes::Color);
};
using HalfedgeMesh = OpenMesh::TriMesh_ArrayKernelT<InterpolatingTraits>;

// Makes `connectivity` that of the mesh. Vertices and faces keep their indices, and a face's own halfedge ends at its
// first corner. OpenMesh's add_face() makes the same of a manifold mesh, but searches all edges of a vertex for each
// face, and refuses what is not manifold. Here each face at an edge that is not manifold (opposite_halfedges.h) gets an
// edge of its own, where the surface ends; and of a vertex with several fans of faces OpenMesh's circulators see one.
void connect(const Mesh& mesh, OpenMesh::TriConnectivity& connectivity);

// With positions and colours, black if the mesh has none.
[[nodiscard]] HalfedgeMesh to_halfedge_mesh(const Mesh& mesh);

// The inverse, corner by corner; of a mesh without deleted elements.
[[nodiscard]] Mesh from_halfedge_mesh(const HalfedgeMesh& halfedge_mesh, bool with_colors);

}  // namespace lumatlas
