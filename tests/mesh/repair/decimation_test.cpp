// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/decimation.h"

#include <catch2/catch.hpp>
#include <stdexcept>

#include "tests/support/scenes/surfaces.h"

namespace lumatlas {
namespace {

TEST_CASE("decimation leaves the faces asked for, as a manifold mesh of nearly the same surface") {
  const Mesh ball = sphere(5);
  for (const double share : {0.5, 0.1, 0.02}) {
    const auto asked = static_cast<std::size_t>(share * static_cast<double>(ball.faces.size()));
    const Mesh fewer = decimated(ball, asked);
    CHECK(fewer.faces.size() <= asked);
    CHECK(fewer.faces.size() + 2 > asked);
    CHECK(is_manifold_and_oriented(fewer));
    CHECK(boundary_edges(fewer) == 0);
    CHECK(volume_of(fewer) == Approx(volume_of(ball)).epsilon(0.001));  // the method keeps volumes
    for (const glm::vec3& p : fewer.positions) CHECK(glm::length(p) == Approx(1).epsilon(0.05));
  }
}

TEST_CASE("decimation keeps edges, corners and the course of boundaries") {
  const Mesh block = decimated(box(12, {1, 2, 3}), 60);
  CHECK(block.faces.size() <= 60);
  CHECK(volume_of(block) == Approx(6).epsilon(1e-4));
  CHECK(area_of(block) == Approx(22).epsilon(1e-4));
  const Mesh sheet = decimated(plane(30, 2), 40);
  CHECK(sheet.faces.size() <= 40);
  CHECK(is_manifold_and_oriented(sheet));
  CHECK(area_of(sheet) == Approx(4).epsilon(1e-4));
  for (const glm::vec3& p : sheet.positions) CHECK(std::abs(p.z) < 1e-5F);
}

TEST_CASE("decimation to more faces than there are changes nothing, and to none stops while the mesh is one") {
  const Mesh block = box(3, {1, 1, 1});
  const Mesh same = decimated(block, 1000);
  CHECK((same.faces == block.faces));
  CHECK((same.positions == block.positions));
  const Mesh least = decimated(block, 0);
  CHECK(least.faces.size() >= 4);
  CHECK(is_manifold_and_oriented(least));
  CHECK(decimated(Mesh{}, 10).faces.empty());
}

TEST_CASE("decimation refuses a mesh that is not manifold by the face") {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}};
  mesh.faces = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  CHECK_THROWS_WITH(decimated(mesh, 1), "decimation: face 2 makes the mesh non-manifold");
}

}  // namespace
}  // namespace lumatlas
