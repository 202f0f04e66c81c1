// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/cut/visibility_cut.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <set>
#include <stdexcept>

#include "tests/support/scenes/surfaces.h"
#include "tests/tools/meshing/seen_sphere.h"

namespace lumatlas {
namespace {

using Views = std::vector<std::vector<std::uint32_t>>;

std::vector<glm::uvec3> cut(const std::vector<glm::dvec3>& points, const Views& views,
                            const std::vector<glm::dvec3>& centers, const CutOptions& options = {}) {
  std::size_t counted = 0;
  std::vector<glm::uvec3> faces =
      cut_surface(points, views, {}, centers, options, [&](std::size_t count) { counted += count; });
  CHECK(counted <= points.size());
  return faces;
}

Mesh mesh_of(const std::vector<glm::dvec3>& points, const std::vector<glm::uvec3>& faces) {
  Mesh mesh;
  for (const glm::dvec3& point : points) mesh.positions.emplace_back(point);
  mesh.faces = faces;
  return mesh;
}

std::set<std::uint32_t> vertices_of(const std::vector<glm::uvec3>& faces) {
  std::set<std::uint32_t> used;
  for (const glm::uvec3& face : faces) used.insert({face.x, face.y, face.z});
  return used;
}

TEST_CASE("points of a sphere seen from around give the sphere, closed and facing outwards") {
  const std::vector<glm::dvec3> points = sphere_points(2000);
  const std::vector<Camera> views = views_around(20);
  const std::vector<glm::uvec3> faces = cut(points, views_that_see(points, views), centers_of(views));
  const Mesh mesh = mesh_of(points, faces);
  CHECK(vertices_of(faces).size() > 1900);
  CHECK(boundary_edges(mesh) == 0);
  CHECK(volume_of(mesh) == Approx(4.18879).epsilon(0.01));
  // The sagitta of an edge of some 0.1 is 0.00125: no face may reach further inside.
  for (const glm::uvec3& face : faces) {
    const glm::dvec3 middle = (points[face.x] + points[face.y] + points[face.z]) / 3.0;
    CHECK(glm::length(middle) > 0.99);
  }
}

TEST_CASE("a room seen from inside faces inwards") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-1, 1);
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 1500; ++i) {
    glm::dvec3 point(place(random), place(random), place(random));
    point[i % 3] = i % 2 == 0 ? -1 : 1;
    points.push_back(point);
  }
  const std::vector<glm::dvec3> centers{{0.3, 0.2, 0}, {-0.3, 0, 0.4}, {0, -0.4, -0.2}};
  const Mesh mesh = mesh_of(points, cut(points, Views(points.size(), {0, 1, 2}), centers));
  CHECK(boundary_edges(mesh) == 0);
  CHECK(volume_of(mesh) == Approx(-8).epsilon(0.05));
}

TEST_CASE("points in the air that lines of sight pass through are left out") {
  std::vector<glm::dvec3> points = sphere_points(1000);
  const std::vector<Camera> views = views_around(20);
  Views seen = views_that_see(points, views);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-1, 1);
  for (int i = 0; i < 60; ++i) {
    const glm::dvec3 direction = glm::normalize(glm::dvec3(place(random), place(random), place(random)));
    points.push_back(direction * (1.5 + 0.5 * place(random) * place(random)));
    seen.push_back({static_cast<std::uint32_t>(i % 20)});  // one mistaken view, often from behind the sphere
  }
  const std::vector<glm::uvec3> faces = cut(points, seen, centers_of(views));
  const std::set<std::uint32_t> used = vertices_of(faces);
  const auto wrong = std::count_if(used.begin(), used.end(), [](std::uint32_t vertex) { return vertex >= 1000; });
  CHECK(used.size() - static_cast<std::size_t>(wrong) > 900);
  CHECK(wrong <= 6);
}

TEST_CASE("the same points give the same faces, and their order is no matter to the surface") {
  std::vector<glm::dvec3> points = sphere_points(300);
  const std::vector<Camera> views = views_around(8);
  const Views seen = views_that_see(points, views);
  const auto faces = cut(points, seen, centers_of(views));
  CHECK(cut(points, seen, centers_of(views)) == faces);
  const double volume = volume_of(mesh_of(points, faces));
  std::reverse(points.begin(), points.end());
  const Views reversed(seen.rbegin(), seen.rend());
  CHECK(volume_of(mesh_of(points, cut(points, reversed, centers_of(views)))) == Approx(volume).epsilon(1e-9));
}

TEST_CASE("a lattice, whose lines of sight run along edges and through corners, makes a surface") {
  std::vector<glm::dvec3> points;
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      for (int z = 0; z < 2; ++z) points.emplace_back(x, y, z);
    }
  }
  const std::vector<glm::dvec3> centers{{0, 0, 5}, {3, 3, 5}, {3.5, 3.5, 4}, {3, 3, 1}};
  CHECK_FALSE(cut(points, Views(points.size(), {0, 1, 2, 3}), centers).empty());
}

TEST_CASE("points that enclose nothing give no face") {
  const std::vector<glm::dvec3> center{{0, 0, 5}};
  CHECK(cut({}, {}, center).empty());
  CHECK(cut({{0, 0, 0}}, {{0}}, center).empty());
  CHECK(cut({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, Views(3, {0}), center).empty());
  std::vector<glm::dvec3> in_plane;
  for (int i = 0; i < 50; ++i) in_plane.emplace_back(i % 7, i / 7, 0);
  CHECK(cut(in_plane, Views(50, {0}), center).empty());
  CHECK(cut(std::vector<glm::dvec3>(20, glm::dvec3(1, 2, 3)), Views(20, {0}), center).empty());
  const std::vector<glm::dvec3> points = sphere_points(50);
  CHECK(cut(points, Views(50), center).empty());  // nobody saw them
  const auto seen_from_itself = cut(points, Views(50, {0}), {points[0]});
  for (const glm::uvec3& face : seen_from_itself) CHECK(std::max({face.x, face.y, face.z}) < 50);
}

TEST_CASE("options and views that break a rule are refused") {
  const std::vector<glm::dvec3> points = sphere_points(10);
  CHECK_THROWS_WITH(cut(points, Views(9), {}), "views: 9 lists, must be one for each of 10 points");
  CHECK_THROWS_WITH(cut(points, Views(10, {2}), {{0, 0, 5}}), "views: 2, but there are 1 centers");
  CutOptions options;
  options.noise = 0;
  CHECK_THROWS_WITH(check(options), "noise: 0, must be in [0.001, 100]");
  options = {};
  options.quality = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(check(options), std::invalid_argument);
  options = {};
  options.sure_views = 1001;
  CHECK_THROWS_AS(check(options), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
