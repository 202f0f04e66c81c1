// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/halfedge_mesh.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "mesh/opposite_halfedges.h"

namespace lumatlas {

namespace {

using OpenMesh::FaceHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

VertexHandle vertex_handle(std::uint32_t vertex) {
  return VertexHandle(static_cast<int>(vertex));
}

template <typename Body>
void for_each_index(std::size_t count, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 4096), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
  });
}

// OpenMesh's halfedge for each one of the triangle list: the two of an edge are neighbours, the first that occurs is
// even, and edges are numbered as they occur. `edges` becomes how many there are.
std::vector<HalfedgeHandle> number_halfedges(const std::vector<std::uint32_t>& opposite, std::size_t& edges) {
  std::vector<HalfedgeHandle> handles(opposite.size());
  edges = 0;
  for (std::size_t i = 0; i < opposite.size(); ++i) {
    const bool is_second = opposite[i] != kNoHalfedge && opposite[i] < i;
    handles[i] =
        is_second ? HalfedgeHandle(handles[opposite[i]].idx() + 1) : HalfedgeHandle(static_cast<int>(2 * edges++));
  }
  return handles;
}

void set_face(OpenMesh::TriConnectivity& connectivity, const glm::uvec3& corners, const HalfedgeHandle* halfedges,
              std::size_t face) {
  const FaceHandle handle(static_cast<int>(face));
  for (int c = 0; c < 3; ++c) {
    const HalfedgeHandle halfedge = halfedges[c];
    connectivity.set_vertex_handle(halfedge, vertex_handle(corners[(c + 1) % 3]));
    connectivity.set_face_handle(halfedge, handle);
    connectivity.set_next_halfedge_handle(halfedge, halfedges[(c + 1) % 3]);
  }
  connectivity.set_halfedge_handle(handle, halfedges[2]);
}

// The boundary halfedge that leaves the vertex at which `inner`, a halfedge on the boundary's other side, begins: the
// other end of the same fan of faces.
HalfedgeHandle end_of_fan(const OpenMesh::TriConnectivity& connectivity, HalfedgeHandle inner) {
  HalfedgeHandle leaving = inner;
  do {
    leaving = connectivity.opposite_halfedge_handle(connectivity.prev_halfedge_handle(leaving));
  } while (!connectivity.is_boundary(leaving));
  return leaving;
}

}  // namespace

void connect(const Mesh& mesh, OpenMesh::TriConnectivity& connectivity) {
  const std::vector<std::uint32_t> opposite = opposite_halfedges(mesh.positions.size(), mesh.faces);
  std::size_t edges = 0;
  const std::vector<HalfedgeHandle> handles = number_halfedges(opposite, edges);
  connectivity.resize(mesh.positions.size(), edges, mesh.faces.size());
  for_each_index(mesh.faces.size(),
                 [&](std::size_t face) { set_face(connectivity, mesh.faces[face], &handles[3 * face], face); });
  // A boundary halfedge ends where the one inside begins.
  for_each_index(handles.size(), [&](std::size_t i) {
    if (opposite[i] != kNoHalfedge) return;
    const HalfedgeHandle outer = connectivity.opposite_halfedge_handle(handles[i]);
    connectivity.set_vertex_handle(outer, vertex_handle(mesh.faces[i / 3][static_cast<int>(i % 3)]));
    connectivity.set_boundary(outer);
  });
  for_each_index(handles.size(), [&](std::size_t i) {
    if (opposite[i] != kNoHalfedge) return;
    const HalfedgeHandle outer = connectivity.opposite_halfedge_handle(handles[i]);
    connectivity.set_next_halfedge_handle(outer, end_of_fan(connectivity, handles[i]));
  });
  // OpenMesh wants the halfedge of a vertex on the boundary to be one of the boundary.
  for (std::size_t i = handles.size(); i-- > 0;) {
    const VertexHandle from = vertex_handle(mesh.faces[i / 3][static_cast<int>(i % 3)]);
    if (!connectivity.halfedge_handle(from).is_valid()) connectivity.set_halfedge_handle(from, handles[i]);
    if (opposite[i] != kNoHalfedge) continue;
    const VertexHandle to = vertex_handle(mesh.faces[i / 3][static_cast<int>((i + 1) % 3)]);
    connectivity.set_halfedge_handle(to, connectivity.opposite_halfedge_handle(handles[i]));
  }
}

HalfedgeMesh to_halfedge_mesh(const Mesh& mesh) {
  HalfedgeMesh result;
  connect(mesh, result);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::vec3& p = mesh.positions[i];
    result.set_point(VertexHandle(static_cast<int>(i)), {p.x, p.y, p.z});
  }
  for (std::size_t i = 0; i < mesh.colors.size(); ++i) {
    const glm::vec3 color(mesh.colors[i]);
    result.set_color(VertexHandle(static_cast<int>(i)), {color.r, color.g, color.b});
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
    const auto halfedge = face.halfedge();  // the one that ends at the first corner
    mesh.faces.emplace_back(halfedge.to().idx(), halfedge.next().to().idx(), halfedge.from().idx());
  }
  return mesh;
}

}  // namespace lumatlas
