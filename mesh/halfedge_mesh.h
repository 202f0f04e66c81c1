// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: OpenMesh's halfedge mesh, for what changes connectivity. Slow to compile: include it in few
// places.
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

// Vertices and faces keep their indices. Throws std::invalid_argument if a face makes the mesh non-manifold.
[[nodiscard]] HalfedgeMesh to_halfedge_mesh(const Mesh& mesh);

// The inverse, corner by corner; of a mesh without deleted elements.
[[nodiscard]] Mesh from_halfedge_mesh(const HalfedgeMesh& halfedge_mesh, bool with_colors);

}  // namespace lumatlas
