// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/far_sphere.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <utility>
#include <vector>

#include "tests/support/scenes/plain_camera.h"

namespace lumatlas {
namespace {

Mesh triangle(float at) {
  return {{{at, 0, 0}, {at, 1, 0}, {at, 0, 1}}, {}, {{0, 1, 2}}};
}

TEST_CASE("the far sphere lies around the cameras, far beyond them and the mesh") {
  std::vector<Camera> cameras;
  for (int i = 0; i < 21; ++i) cameras.push_back(plain_camera({0.1 * i - 1, 5, 0}));
  const SphereShape near_mesh = far_sphere_shape(cameras, triangle(2));
  CHECK(glm::distance(near_mesh.center, glm::dvec3(0, 5, 0)) < 1e-9);
  CHECK(near_mesh.radius == Approx(300 * 0.9));
  const SphereShape distant_mesh = far_sphere_shape(cameras, triangle(1000));
  CHECK(distant_mesh.radius > 9900);
  CHECK(distant_mesh.radius < 10100);
  CHECK(far_sphere_shape({cameras.data(), 1}, triangle(2)).radius > 10);
  // A camera that was placed wrongly.
  cameras[3] = plain_camera({1e12, 0, 0});
  const SphereShape with_stray = far_sphere_shape(cameras, triangle(2));
  CHECK(glm::distance(with_stray.center, near_mesh.center) < 0.2);
  CHECK(with_stray.radius < 2 * near_mesh.radius);
  CHECK_THROWS_WITH(far_sphere_shape({}, triangle(2)), "far sphere: the number of cameras is 0, must be at least 1");
  CHECK_THROWS_WITH(far_sphere_shape(cameras, Mesh{}), "far sphere: the number of faces is 0, must be at least 1");
}

TEST_CASE("the far sphere is closed, even, and turned inwards") {
  const SphereShape shape{{10, -20, 30}, 500};
  for (const double longest : {0.5, 0.1}) {
    const Mesh sphere = far_sphere(shape, longest);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const glm::vec3& position : sphere.positions) {
      CHECK(glm::distance(glm::dvec3(position), shape.center) == Approx(shape.radius).epsilon(1e-6));
    }
    for (const glm::uvec3& face : sphere.faces) {
      const glm::dvec3 a(sphere.positions[face.x]), b(sphere.positions[face.y]), c(sphere.positions[face.z]);
      CHECK(glm::dot(glm::cross(b - a, c - a), shape.center - a) > 0);
      for (int corner = 0; corner < 3; ++corner) {
        const std::uint32_t from = face[corner], to = face[(corner + 1) % 3];
        ++edges[{from, to}];
        CHECK(glm::distance(sphere.positions[from], sphere.positions[to]) <= longest * shape.radius);
      }
    }
    for (const auto& [edge, count] : edges) {
      CHECK(count == 1);
      CHECK(edges.contains({edge.second, edge.first}));
    }
  }
  CHECK_THROWS_WITH(far_sphere(shape, 0), "far sphere: longest_edge is 0, must be in (0, 1]");
  CHECK_THROWS_WITH(far_sphere(shape, 1.5), "far sphere: longest_edge is 1.5, must be in (0, 1]");
}

}  // namespace
}  // namespace lumatlas
