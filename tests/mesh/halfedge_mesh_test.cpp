// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/halfedge_mesh.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <cstdint>
#include <vector>

#include "mesh/opposite_halfedges.h"
#include "tests/support/scenes/surfaces.h"

namespace lumatlas {
namespace {

using Opposite = std::vector<std::uint32_t>;

// The same mesh face by face.
HalfedgeMesh added(const Mesh& mesh) {
  HalfedgeMesh result;
  for (const glm::vec3& p : mesh.positions) result.add_vertex({p.x, p.y, p.z});
  for (const glm::ivec3 face : mesh.faces) {
    REQUIRE(
        result.add_face(OpenMesh::VertexHandle(face.x), OpenMesh::VertexHandle(face.y), OpenMesh::VertexHandle(face.z))
            .is_valid());
  }
  return result;
}

TEST_CASE("a halfedge mesh made at once is the one that OpenMesh makes face by face") {
  for (const Mesh& mesh : {sphere(3), plane(9, 1), joined(box(4, {1, 2, 3}), plane(3, 1)), plane(1, 1)}) {
    const HalfedgeMesh expected = added(mesh);
    const HalfedgeMesh made = to_halfedge_mesh(mesh);
    REQUIRE(made.n_vertices() == expected.n_vertices());
    REQUIRE(made.n_edges() == expected.n_edges());
    REQUIRE(made.n_faces() == expected.n_faces());
    for (const auto halfedge : expected.halfedges()) {
      CHECK(made.to_vertex_handle(halfedge) == expected.to_vertex_handle(halfedge));
      CHECK(made.face_handle(halfedge) == expected.face_handle(halfedge));
      CHECK(made.next_halfedge_handle(halfedge) == expected.next_halfedge_handle(halfedge));
      CHECK(made.prev_halfedge_handle(halfedge) == expected.prev_halfedge_handle(halfedge));
    }
    for (const auto face : expected.faces()) CHECK(made.halfedge_handle(face) == expected.halfedge_handle(face));
    for (const auto vertex : expected.vertices()) {
      CHECK(made.is_boundary(vertex) == expected.is_boundary(vertex));
      CHECK(made.valence(vertex) == expected.valence(vertex));
      CHECK(made.point(vertex) == expected.point(vertex));
    }
    const Mesh back = from_halfedge_mesh(made, false);
    CHECK(back.positions == mesh.positions);
    CHECK(back.faces == mesh.faces);
  }
}

TEST_CASE("the surface ends at edges that are not manifold") {
  // Two triangles side by side share the edge from 0 to 1.
  CHECK(opposite_halfedges(4, std::vector<glm::uvec3>{{0, 1, 2}, {1, 0, 3}}) ==
        Opposite{3, kNoHalfedge, kNoHalfedge, 0, kNoHalfedge, kNoHalfedge});
  const Opposite six(6, kNoHalfedge), nine(9, kNoHalfedge);
  CHECK(opposite_halfedges(4, std::vector<glm::uvec3>{{0, 1, 2}, {0, 1, 3}}) == six);
  CHECK(opposite_halfedges(5, std::vector<glm::uvec3>{{0, 1, 2}, {1, 0, 3}, {1, 0, 4}}) == nine);
  CHECK(opposite_halfedges(2, std::vector<glm::uvec3>{{0, 0, 1}}) == Opposite(3, kNoHalfedge));
  CHECK(opposite_halfedges(0, std::vector<glm::uvec3>{}).empty());
}

TEST_CASE("fans that touch at a vertex each have a boundary of their own") {
  const Mesh bow_tie{{{0, 0, 0}, {1, 1, 0}, {1, -1, 0}, {-1, 1, 0}, {-1, -1, 0}}, {}, {{0, 2, 1}, {0, 3, 4}}};
  const HalfedgeMesh mesh = to_halfedge_mesh(bow_tie);
  CHECK(mesh.n_edges() == 6);
  for (const auto halfedge : mesh.halfedges()) {
    CHECK(halfedge.next().prev() == halfedge);
    CHECK(halfedge.next().from() == halfedge.to());
    CHECK(halfedge.next().next().next() == halfedge);  // round its triangle, inside or outside
  }
}

// Faces that count how often one is looked at.
class CountedFaces {
 public:
  explicit CountedFaces(const std::vector<glm::uvec3>& faces) : faces_(faces) {}
  [[nodiscard]] std::size_t size() const { return faces_.size(); }
  const glm::uvec3& operator[](std::size_t face) const {
    ++looks_;
    return faces_[face];
  }
  [[nodiscard]] std::uint64_t looks() const { return looks_; }

 private:
  const std::vector<glm::uvec3>& faces_;
  mutable std::atomic<std::uint64_t> looks_ = 0;
};

TEST_CASE("finding neighbours takes no longer where many faces meet at a vertex") {
  constexpr std::uint32_t kCorners = 100'000;
  std::vector<glm::uvec3> fan;
  for (std::uint32_t i = 0; i < kCorners; ++i) fan.emplace_back(0, 1 + i, 1 + (i + 1) % kCorners);
  const CountedFaces counted(fan);
  const Opposite opposite = opposite_halfedges(kCorners + 1, counted);
  CHECK(counted.looks() <= 2 * fan.size());  // searching round the vertices: 10^10
  for (std::uint32_t i = 0; i < kCorners; ++i) {
    CHECK(opposite[3 * i + 2] == 3 * ((i + 1) % kCorners));
    CHECK(opposite[3 * i + 1] == kNoHalfedge);
  }
}

}  // namespace
}  // namespace lumatlas
