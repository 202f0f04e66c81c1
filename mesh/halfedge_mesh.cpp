// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/halfedge_mesh.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace lumatlas {

HalfedgeMesh to_halfedge_mesh(const Mesh& mesh) {
  HalfedgeMesh result;
  // For a closed mesh; a boundary adds a few edges.
  result.reserve(mesh.positions.size(), mesh.faces.size() * 3 / 2, mesh.faces.size());
  for (const glm::vec3& p : mesh.positions) result.add_vertex({p.x, p.y, p.z});
  for (std::size_t i = 0; i < mesh.colors.size(); ++i) {
    const glm::vec3 color(mesh.colors[i]);
    result.set_color(OpenMesh::VertexHandle(static_cast<int>(i)), {color.r, color.g, color.b});
  }
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const glm::ivec3 face(mesh.faces[i]);
    const auto added =
        result.add_face(OpenMesh::VertexHandle(face.x), OpenMesh::VertexHandle(face.y), OpenMesh::VertexHandle(face.z));
    if (added.is_valid()) continue;
    throw std::invalid_argument("mesh: face " + std::to_string(i) +
                                " makes an edge or a vertex non-manifold, must be repaired first");
  }
  return result;
}

Mesh from_halfedge_mesh(const HalfedgeMesh& halfedge_mesh, bool with_colors) {
  Mesh mesh;
  mesh.positions.reserve(halfedge_mesh.n_vertices());
  mesh.faces.reserve(halfedge_mesh.n_faces());
  for (const auto vertex : halfedge_mesh.vertices()) {
    const auto& p = halfedge_mesh.point(vertex);
    mesh.positions.emplace_back(p[0], p[1], p[2]);
    if (!with_colors) continue;
    const auto& color = halfedge_mesh.color(vertex);
    mesh.colors.emplace_back(std::lround(color[0]), std::lround(color[1]), std::lround(color[2]));
  }
  for (const auto face : halfedge_mesh.faces()) {
    const auto halfedge = face.halfedge();  // add_face sets the one that ends at the first corner
    mesh.faces.emplace_back(halfedge.to().idx(), halfedge.next().to().idx(), halfedge.from().idx());
  }
  return mesh;
}

}  // namespace lumatlas
