// SPDX-License-Identifier: GPL-3.0-or-later
// How much memory the helpers of a mesh take beside it, in bytes a face: a law, so that it holds for any mesh.
#include <catch2/catch.hpp>
#include <cstddef>
#include <functional>
#include <utility>

#include "mesh/cells/split_faces.h"
#include "mesh/repair/holes.h"
#include "mesh/repair/repair.h"
#include "mesh/scene_extent.h"
#include "tests/support/allocation_peak.h"
#include "tests/support/scenes/surfaces.h"
#include "tests/support/skip.h"

namespace lumatlas {
namespace {

constexpr std::uint32_t kMemoryQuads = 300;  // a plane of 180,000 faces

double bytes_a_face(std::size_t faces, const std::function<void()>& work) {
  const AllocationPeak peak;
  work();
  return static_cast<double>(peak.bytes()) / static_cast<double>(faces);
}

double bytes_of_repair(const TriangleSoup& soup) {
  return bytes_a_face(soup.faces.size(), [&] { (void)repair(soup, glm::dvec3(0)); });
}

TriangleSoup plane_soup() {
  return to_soup(plane(kMemoryQuads, 1));
}

// A face in the middle of the plane.
constexpr std::size_t kInside = std::size_t{kMemoryQuads} * kMemoryQuads + kMemoryQuads;

TEST_CASE("the extent of a scene takes little memory beside its mesh") {
  if (!allocations_are_counted()) return skip("a sanitizer has its own operator new");
  const Mesh mesh = plane(kMemoryQuads, 1);
  CHECK(bytes_a_face(mesh.faces.size(), [&] { (void)scene_extent(mesh); }) < 20);
  Mesh with_stray = mesh;
  with_stray.positions[kMemoryQuads / 2] = {0.5f, -1e6f, 0};  // a vertex of the rim far away: its faces are spikes
  CHECK(bytes_a_face(mesh.faces.size(), [&] { (void)scene_extent(with_stray); }) < 20);
}

TEST_CASE("one defect of a soup costs no more memory than none") {
  if (!allocations_are_counted()) return skip("a sanitizer has its own operator new");
  const TriangleSoup clean = plane_soup();
  const double least = bytes_of_repair(clean);
  CAPTURE(least);
  CHECK(least < 60);
  const auto more_with = [&](const std::function<void(TriangleSoup&)>& damage) {
    TriangleSoup soup = clean;
    damage(soup);
    return bytes_of_repair(soup) - least;
  };
  const glm::uvec3 face = clean.faces[kInside];
  CHECK(more_with([&](TriangleSoup& soup) { std::swap(soup.faces[kInside].x, soup.faces[kInside].y); }) < 12);
  CHECK(more_with([&](TriangleSoup& soup) { soup.faces.push_back(face); }) < 12);
  const auto add_vertex = [](TriangleSoup& soup, const glm::dvec3& position) {
    soup.positions.push_back(position);
    soup.colors.emplace_back(0);
    return static_cast<std::uint32_t>(soup.positions.size() - 1);
  };
  CHECK(more_with([&](TriangleSoup& soup) {  // a fin: an edge with three faces
          soup.faces.emplace_back(face.x, face.y, add_vertex(soup, {0.5, 0.5, 1}));
        }) < 12);
  CHECK(more_with([&](TriangleSoup& soup) {  // a face that shares one vertex with the others
          const std::uint32_t a = add_vertex(soup, {0.5, 0.5, 1}), b = add_vertex(soup, {0.5, 0.6, 1});
          soup.faces.emplace_back(face.x, a, b);
        }) < 12);
  CHECK(more_with([&](TriangleSoup& soup) {  // a vertex twice
          soup.faces[kInside].x = add_vertex(soup, soup.positions[face.x]);
        }) < 12);
  CHECK(more_with([&](TriangleSoup& soup) { add_vertex(soup, {0.5, 0.5, 1}); }) < 12);  // used by no face
}

TEST_CASE("vertices that each face has for itself are merged with little memory") {
  if (!allocations_are_counted()) return skip("a sanitizer has its own operator new");
  const TriangleSoup shared = plane_soup();
  TriangleSoup apart;  // as an STL file has them
  for (const glm::uvec3& face : shared.faces) {
    for (int corner = 0; corner < 3; ++corner) apart.positions.push_back(shared.positions[face[corner]]);
    const auto first = static_cast<std::uint32_t>(apart.positions.size() - 3);
    apart.faces.emplace_back(first, first + 1, first + 2);
  }
  CHECK(bytes_of_repair(apart) < 250);  // 3 vertices a face: 96 bytes of points, 24 of hashes, 48 of those repeated
}

TEST_CASE("one small hole costs little memory beside the mesh that is returned") {
  if (!allocations_are_counted()) return skip("a sanitizer has its own operator new");
  Mesh mesh = plane(kMemoryQuads, 1);
  const double returned = bytes_a_face(mesh.faces.size(), [&] { const Mesh copy = mesh; });
  mesh.faces.erase(mesh.faces.begin() + static_cast<std::ptrdiff_t>(kInside));
  ClosedHoles closed;
  const double taken = bytes_a_face(mesh.faces.size(), [&] { closed = close_holes(mesh, 0.1); });
  CHECK(closed.holes == 1);
  CHECK(taken < returned + 5);  // what finds the hole takes as much before, and is gone when the copy is made
}

TEST_CASE("splitting faces takes no more memory than its limit expects") {
  if (!allocations_are_counted()) return skip("a sanitizer has its own operator new");
  const Mesh wall = plane(1, 1);
  std::size_t faces = 0;
  const double bytes = bytes_a_face(1, [&] { faces = split_large_faces(wall, 0.005).faces.size(); });
  CAPTURE(faces, bytes / static_cast<double>(faces));
  CHECK(bytes < 400 * static_cast<double>(faces));
}

}  // namespace
}  // namespace lumatlas
