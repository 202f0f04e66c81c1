// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/decimation.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace lumatlas {
namespace {

namespace simplification = CGAL::Surface_mesh_simplification;
using DoubleKernel = CGAL::Simple_cartesian<double>;
using CgalMesh = CGAL::Surface_mesh<DoubleKernel::Point_3>;
using CgalVertex = CgalMesh::Vertex_index;

CgalMesh to_cgal(const Mesh& mesh) {
  CgalMesh result;
  result.reserve(static_cast<CgalMesh::size_type>(mesh.positions.size()),
                 static_cast<CgalMesh::size_type>(3 * mesh.faces.size() / 2),
                 static_cast<CgalMesh::size_type>(mesh.faces.size()));
  for (const glm::vec3& p : mesh.positions) result.add_vertex({p.x, p.y, p.z});
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const glm::uvec3& f = mesh.faces[i];
    if (result.add_face(CgalVertex(f.x), CgalVertex(f.y), CgalVertex(f.z)) == CgalMesh::null_face()) {
      throw std::invalid_argument("decimation: face " + std::to_string(i) + " makes the mesh non-manifold");
    }
  }
  return result;
}

Mesh from_cgal(const CgalMesh& mesh) {
  Mesh result;
  std::vector<std::uint32_t> index(mesh.num_vertices());
  for (const CgalVertex vertex : mesh.vertices()) {
    index[vertex] = static_cast<std::uint32_t>(result.positions.size());
    const DoubleKernel::Point_3& p = mesh.point(vertex);
    result.positions.emplace_back(p.x(), p.y(), p.z());
  }
  for (const CgalMesh::Face_index face : mesh.faces()) {
    const CgalMesh::Halfedge_index edge = mesh.halfedge(face);
    const auto corner = [&](CgalMesh::Halfedge_index to) { return index[mesh.target(to)]; };
    result.faces.emplace_back(corner(edge), corner(mesh.next(edge)), corner(mesh.next(mesh.next(edge))));
  }
  return result;
}

struct EnoughFaces {
  std::size_t faces;
  template <typename Cost, typename Profile>
  bool operator()(const Cost& /*cost*/, const Profile& profile, std::size_t /*edges_before*/,
                  std::size_t /*edges*/) const {
    return profile.surface_mesh().number_of_faces() <= faces;
  }
};

}  // namespace

Mesh decimated(const Mesh& mesh, std::size_t faces) {
  check(mesh);
  CgalMesh collapsed = to_cgal(mesh);
  simplification::edge_collapse(collapsed, EnoughFaces{faces},
                                CGAL::parameters::filter(simplification::Bounded_normal_change_filter<>())
                                    .get_cost(simplification::LindstromTurk_cost<CgalMesh>())
                                    .get_placement(simplification::LindstromTurk_placement<CgalMesh>()));
  return from_cgal(collapsed);
}

}  // namespace lumatlas
