// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/simplification.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "tests/support/scenes/surfaces.h"

namespace lumatlas {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The furthest that a corner, an edge's middle or a face's middle is from the unit sphere.
double distance_from_ball(const Mesh& mesh) {
  double furthest = 0;
  const auto look = [&](const glm::vec3& point) {
    furthest = std::max(furthest, std::abs(1.0 - static_cast<double>(glm::length(point))));
  };
  for (const glm::uvec3& face : mesh.faces) {
    const glm::vec3& a = mesh.positions[face.x];
    const glm::vec3& b = mesh.positions[face.y];
    const glm::vec3& c = mesh.positions[face.z];
    for (const glm::vec3& point : {a, (a + b) / 2.0F, (b + c) / 2.0F, (c + a) / 2.0F, (a + b + c) / 3.0F}) look(point);
  }
  return furthest;
}

// One unit above the middle of plane(), looking down at it; a pixel there is 1/100 wide.
Camera above_plane(float side) {
  Camera camera;
  camera.width = camera.height = 1000;
  camera.fx = camera.fy = 100;
  camera.cx = camera.cy = 500;
  camera.cam_from_world_rotation = glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1);
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * glm::dvec3(side / 2, side / 2, 1));
  return camera;
}

TEST_CASE("simplification moves a ball's surface by about what it is allowed and says, and keeps it closed") {
  const Mesh ball = sphere(6);
  std::size_t last = ball.faces.size();
  for (const double distance : {0.0005, 0.002, 0.01}) {
    const SimplifiedMesh fewer = simplified(ball, {distance, 0});
    CHECK(fewer.distance > distance / 4);
    CHECK(fewer.distance <= distance * (1 + 1e-6));
    CHECK(distance_from_ball(fewer.mesh) < 4 * distance);  // quadrics weigh mean distances from planes
    CHECK(10 * fewer.mesh.faces.size() < 6 * last);
    CHECK(is_manifold_and_oriented(fewer.mesh));
    CHECK(boundary_edges(fewer.mesh) == 0);
    last = fewer.mesh.faces.size();
  }
}

TEST_CASE("simplification of what is flat leaves corners, colours and the course of boundaries") {
  const Mesh sheet = plane(40, 2);
  const SimplifiedMesh fewer = simplified(sheet, {1e-4, 0});
  CHECK(fewer.mesh.faces.size() < sheet.faces.size() / 50);
  CHECK(area_of(fewer.mesh) == Approx(4).epsilon(1e-6));
  REQUIRE(fewer.mesh.colors.size() == fewer.mesh.positions.size());
  for (std::size_t i = 0; i < fewer.mesh.positions.size(); ++i) {
    const auto at = std::find(sheet.positions.begin(), sheet.positions.end(), fewer.mesh.positions[i]);
    REQUIRE(at != sheet.positions.end());
    CHECK((fewer.mesh.colors[i] == sheet.colors[static_cast<std::size_t>(at - sheet.positions.begin())]));
  }
  const Mesh block = simplified(box(12, {1, 2, 3}), {2e-3, 0}).mesh;
  CHECK(volume_of(block) == Approx(6).epsilon(1e-3));
  CHECK(block.faces.size() <= 24);
}

TEST_CASE("simplification stops at a number of faces, and leaves alone what has no more") {
  const Mesh ball = sphere(5);
  const Mesh fewer = simplified(ball, {kInfinity, 1000}).mesh;
  CHECK(fewer.faces.size() <= 1000);
  CHECK(fewer.faces.size() > 900);
  CHECK(distance_from_ball(fewer) < 0.05);
  for (const SimplificationBound& bound :
       {SimplificationBound{kInfinity, ball.faces.size()}, SimplificationBound{0, 0}}) {
    const SimplifiedMesh same = simplified(ball, bound);
    CHECK((same.mesh.faces == ball.faces));
    CHECK((same.mesh.positions == ball.positions));
    CHECK(same.distance == 0);
  }
  CHECK(simplified(Mesh{}, {1, 0}).mesh.faces.empty());
  CHECK(is_manifold_and_oriented(simplified(ball, {kInfinity, 0}).mesh));
  CHECK_FALSE(simplified(ball, {kInfinity, 0}).mesh.faces.empty());
}

TEST_CASE("a mesh of pieces that touch stays manifold when it is simplified") {
  Mesh pieces = sphere(4);
  for (int i = 1; i < 5; ++i) pieces = joined(pieces, moved(sphere(4), {0.02F * static_cast<float>(i), 0, 0}));
  CHECK(is_manifold_and_oriented(simplified(pieces, {0.05, 0}).mesh));
}

TEST_CASE("a pixel's size on the surface is depth over focal length where the nearest cameras see it") {
  const Mesh sheet = plane(10, 2);
  const Camera near = above_plane(2);
  Camera far = near;
  far.cam_from_world_translation.z += 3;
  CHECK(pixel_size(sheet, std::vector{near}, 0.5) == Approx(0.01));
  CHECK(pixel_size(sheet, std::vector{far}, 0.5) == Approx(0.04));
  CHECK(pixel_size(sheet, std::vector{far, near}, 1) == Approx(0.01));
  Camera narrow = near;
  narrow.width = narrow.height = 20;  // sees the middle vertex alone
  narrow.cx = narrow.cy = 10;
  CHECK(pixel_size(sheet, std::vector{far, narrow}, 0) == Approx(0.01));
  CHECK(pixel_size(sheet, std::vector{far, narrow}, 0.5) == Approx(0.04));
  Camera away = near;
  away.cam_from_world_rotation = glm::dmat3(1);
  away.cam_from_world_translation = -glm::dvec3(1, 1, 1);
  CHECK(pixel_size(sheet, std::vector{away}, 0.5) == kInfinity);
  CHECK(pixel_size(sheet, {}, 0.5) == kInfinity);
}

TEST_CASE("simplification refuses what is no distance and no share") {
  const Mesh ball = sphere(1);
  CHECK_THROWS_WITH(simplified(ball, {-1, 0}), "simplification: bound.distance is -1.000000, must not be negative");
  CHECK_THROWS_AS(simplified(ball, {std::nan(""), 0}), std::invalid_argument);
  CHECK_THROWS_WITH(pixel_size(ball, {}, 2), "pixel size: share is 2.000000, must be in [0, 1]");
  CHECK_THROWS_AS(pixel_size(ball, std::vector{Camera{}}, 0.5), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
