// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/holes.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <random>
#include <stdexcept>

#include "mesh/opposite_halfedges.h"
#include "mesh/repair/repair.h"
#include "tests/support/scenes/surfaces.h"

namespace lumatlas {
namespace {

std::size_t open_edges(const Mesh& mesh) {
  const auto opposite = opposite_halfedges(mesh.positions.size(), mesh.faces);
  return static_cast<std::size_t>(std::count(opposite.begin(), opposite.end(), kNoHalfedge));
}

double area(const Mesh& mesh) {
  double sum = 0;
  for (const glm::uvec3& face : mesh.faces) {
    const glm::dvec3 a(mesh.positions[face.x]), b(mesh.positions[face.y]), c(mesh.positions[face.z]);
    sum += glm::length(glm::cross(b - a, c - a)) / 2;
  }
  return sum;
}

// A plane of `quads` x `quads` without the faces that `gone` says yes to, by their middle as shares of the side.
template <typename Gone>
Mesh pierced(std::uint32_t quads, float side, const Gone& gone) {
  Mesh mesh = plane(quads, side);
  const Bounds box = bounds(mesh);
  std::erase_if(mesh.faces, [&](const glm::uvec3& face) {
    const glm::dvec3 middle =
        (glm::dvec3(mesh.positions[face.x]) + glm::dvec3(mesh.positions[face.y]) + glm::dvec3(mesh.positions[face.z])) /
        3.0;
    const glm::dvec3 share = (middle - box.min) / static_cast<double>(side);
    return gone(share.x, share.y);
  });
  TriangleSoup soup;
  soup.positions.assign(mesh.positions.begin(), mesh.positions.end());
  soup.faces = mesh.faces;
  return repair(soup, glm::dvec3(0)).mesh;  // without the vertices that no face has any more
}

bool in_small_hole(double x, double y) {
  return x > 0.2 && x < 0.3 && y > 0.2 && y < 0.3;
}
bool in_large_hole(double x, double y) {
  return x > 0.5 && x < 0.8 && y > 0.5 && y < 0.8;
}

TEST_CASE("holes up to the size are closed, larger ones and the rim stay, and all faces turn the same way") {
  const Mesh holey = pierced(20, 10, [](double x, double y) { return in_small_hole(x, y) || in_large_hole(x, y); });
  const std::size_t rim = 4 * 20;
  REQUIRE(open_edges(holey) == rim + 8 + 24);
  const ClosedHoles small = close_holes(holey, 2);  // the smaller one is 1 x 1, with a diagonal of 1.41
  CHECK(small.holes == 1);
  CHECK(small.faces == 6);
  CHECK(open_edges(small.mesh) == rim + 24);
  CHECK(area(small.mesh) == Approx(100 - 9));
  const ClosedHoles both = close_holes(holey, 4.5);
  CHECK(both.holes == 2);
  CHECK(open_edges(both.mesh) == rim);  // an edge with faces that turn against each other would count as boundary
  CHECK(area(both.mesh) == Approx(100));
  CHECK(both.mesh.positions == holey.positions);
}

TEST_CASE("the rim of a piece is no hole, however small the piece is") {
  const Mesh piece = plane(3, 0.1f);
  const ClosedHoles closed = close_holes(piece, 100);
  CHECK(closed.holes == 0);
  CHECK(closed.mesh.faces == piece.faces);
}

TEST_CASE("a mesh without boundary, or a size of 0, changes nothing; sizes that are none are refused") {
  const Mesh holey = pierced(20, 10, in_small_hole);
  CHECK(close_holes(holey, 0).mesh.faces == holey.faces);
  CHECK(close_holes(holey, 1.3).holes == 0);
  for (const double wrong : {-1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
    CHECK_THROWS_AS(close_holes(holey, wrong), std::invalid_argument);
  }
}

// Returns a plane with a hole of `edges` edges, whose border goes to and fro: no Delaunay triangulation of its vertices
// has all of the border's edges.
Mesh with_jagged_hole(std::uint32_t edges) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> radius(0.7, 1), height(-0.3, 0.3);
  Mesh mesh;
  for (const bool is_hole : {true, false}) {
    for (std::uint32_t i = 0; i < edges; ++i) {
      const double angle = 2 * 3.14159265358979 * i / edges;
      const double r = is_hole ? radius(random) : 3, h = is_hole ? height(random) : 0;
      mesh.positions.emplace_back(r * std::cos(angle), r * std::sin(angle), h);
    }
  }
  for (std::uint32_t i = 0; i < edges; ++i) {
    const std::uint32_t next = (i + 1) % edges;
    mesh.faces.emplace_back(i, edges + i, edges + next);
    mesh.faces.emplace_back(i, edges + next, next);
  }
  return mesh;
}

TEST_CASE("a jagged hole is closed in a number of steps that does not grow with the cube of its edges") {
  for (const std::uint32_t edges : {40u, 240u, 1000u, 8000u}) {
    const Mesh holey = with_jagged_hole(edges);
    std::size_t checks = 0;
    const ClosedHoles closed = close_holes(holey, 3, [&] { ++checks; });
    CAPTURE(edges, checks);
    CHECK(closed.holes == 1);
    CHECK(closed.faces == edges - 2);
    CHECK(open_edges(closed.mesh) == edges);  // the rim
    CHECK(checks < 50'000);
  }
}

TEST_CASE("the filling of one hole ends when its cancel_check throws") {
  const Mesh holey = with_jagged_hole(240);  // filled by the best of all triangles, in millions of steps
  int checks = 0;
  const CancelCheck third = [&] {
    if (++checks == 3) throw std::runtime_error("enough");
  };
  CHECK_THROWS_WITH(close_holes(holey, 3, third), "enough");
  CHECK(checks == 3);
}

}  // namespace
}  // namespace lumatlas
