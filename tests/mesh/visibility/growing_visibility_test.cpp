// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/visibility/growing_visibility.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <stdexcept>
#include <utility>

namespace lumatlas {
namespace {

// A sheet of 2 * 80^2 faces over the square of side 4 around the origin, with hills and a valley that grows.
Mesh valley_sheet(double depth) {
  constexpr std::uint32_t kQuads = 80;
  Mesh mesh;
  for (std::uint32_t j = 0; j <= kQuads; ++j) {
    for (std::uint32_t i = 0; i <= kQuads; ++i) {
      const double x = 4.0 * i / kQuads - 2, y = 4.0 * j / kQuads - 2;
      const double valley = std::hypot(x - 1, y - 1) < 0.4 ? depth : 0;
      mesh.positions.emplace_back(x, y, 0.1 * std::sin(9 * x) * std::sin(7 * y) - valley);
    }
  }
  for (std::uint32_t j = 0; j < kQuads; ++j) {
    for (std::uint32_t i = 0; i < kQuads; ++i) {
      const std::uint32_t a = j * (kQuads + 1) + i, c = a + kQuads + 2;
      mesh.faces.insert(mesh.faces.end(), {{a, a + 1, c}, {a, c, c - 1}});
    }
  }
  return mesh;
}

Camera above() {
  Camera camera = centered_camera(420, 360, 300);
  camera.cam_from_world_rotation = glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1);
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * glm::dvec3(0.1, 0.2, 3));
  return camera;
}

// Returns the share of pixels at which both see the same face at the same depth, except for the last bits.
double agreement(const VisibilityBuffer& a, const VisibilityBuffer& b) {
  REQUIRE(a.face.size() == b.face.size());
  std::size_t same = 0;
  for (std::size_t pixel = 0; pixel < a.face.size(); ++pixel) {
    const bool both_see_none = a.face[pixel] == FaceId::none && b.face[pixel] == FaceId::none;
    same += both_see_none || (a.face[pixel] == b.face[pixel] && std::abs(a.depth[pixel] / b.depth[pixel] - 1) < 1e-6F);
  }
  return static_cast<double>(same) / static_cast<double>(a.face.size());
}

TEST_CASE("a mesh in cubes is seen as the whole mesh, version by version, and only cubes that changed are made") {
  GrowingVisibility growing(0.5);
  std::unique_ptr<Visibility> before;
  VisibilityBuffer seen_before;
  for (const double depth : {0.0, 0.3, 0.3, 0.5}) {
    CAPTURE(depth);
    const Mesh mesh = valley_sheet(depth);
    const std::unique_ptr<Visibility> whole = make_ray_visibility(mesh);
    std::unique_ptr<Visibility> now = growing.of(mesh);
    CHECK(agreement(now->trace(above()), whole->trace(above())) > 0.999);
    CHECK(agreement(now->trace_sparsely(above()), whole->trace_sparsely(above())) > 0.999);
    CHECK(growing.cubes() > 60);
    if (!before) {
      CHECK(growing.cubes_made() == growing.cubes());
    } else {
      CHECK(growing.cubes_made() < growing.cubes() / 4);
      // The version before goes on to show what it showed.
      CHECK(agreement(before->trace(above()), seen_before) == 1);
    }
    before = std::move(now);
    seen_before = before->trace(above());
  }
  (void)growing.of(valley_sheet(0.5));
  CHECK(growing.cubes_made() == 0);
}

TEST_CASE("cubes are made again where faces are at other places or in another order, and not for other vertices") {
  const Mesh mesh = valley_sheet(0.3);
  GrowingVisibility growing(0.5);
  const VisibilityBuffer seen = growing.of(mesh)->trace(above());
  Mesh apart;  // each face with vertices of its own
  for (const glm::uvec3& face : mesh.faces) {
    const auto first = static_cast<std::uint32_t>(apart.positions.size());
    for (int corner = 0; corner < 3; ++corner) apart.positions.push_back(mesh.positions[face[corner]]);
    apart.faces.emplace_back(first, first + 1, first + 2);
  }
  CHECK(agreement(growing.of(apart)->trace(above()), seen) == 1);
  CHECK(growing.cubes_made() == 0);
  Mesh turned = mesh;
  std::swap(turned.faces[0].y, turned.faces[0].z);
  (void)growing.of(turned);
  CHECK(growing.cubes_made() == 1);
  Mesh moved = turned;
  moved.positions[0].z = std::nextafter(moved.positions[0].z, 1.0F);
  (void)growing.of(moved);
  CHECK(growing.cubes_made() == 1);
  moved.faces.pop_back();
  (void)growing.of(moved);
  CHECK(growing.cubes_made() == 1);
  std::swap(moved.faces[0], moved.faces[1]);
  const VisibilityBuffer swapped = growing.of(moved)->trace(above());
  CHECK(growing.cubes_made() == 1);
  CHECK(agreement(swapped, make_ray_visibility(moved)->trace(above())) > 0.999);
}

TEST_CASE("no ray passes between two cubes") {
  Mesh sheet = valley_sheet(0);
  const VisibilityBuffer seen = GrowingVisibility(0.13).of(sheet)->trace(above());
  std::size_t holes = 0;
  for (std::uint32_t y = 20; y < 340; ++y) {
    for (std::uint32_t x = 60; x < 360; ++x) holes += seen.face[y * seen.width + x] == FaceId::none;
  }
  CHECK(holes == 0);
}

TEST_CASE("a growing visibility refuses what a visibility refuses") {
  CHECK_THROWS_WITH(GrowingVisibility(0), Catch::Contains("side is 0"));
  CHECK_THROWS_AS(GrowingVisibility(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  GrowingVisibility growing(1);
  CHECK_THROWS_AS(growing.of(Mesh{}), std::invalid_argument);
  Mesh bad = valley_sheet(0);
  bad.faces.front().x = 1U << 30U;
  CHECK_THROWS_AS(growing.of(bad), std::invalid_argument);
  bad = valley_sheet(0);
  for (glm::vec3& p : bad.positions) p *= 1e12F;  // beyond the numbers of cubes
  CHECK(growing.of(bad) != nullptr);
}

}  // namespace
}  // namespace lumatlas
