// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/estimated_views.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <mutex>

#include "tests/tools/meshing/seen_sphere.h"

namespace lumatlas {
namespace {

// A wall at z = 10 with a smaller one before it at z = 4, seen along z.
struct TwoWalls {
  std::vector<glm::dvec3> points;
  std::size_t first_behind = 0;
  Camera view;

  TwoWalls() {
    for (double x = -1; x <= 1; x += 0.05) {
      for (double y = -1; y <= 1; y += 0.05) points.emplace_back(x, y, 4);
    }
    first_behind = points.size();
    for (double x = -4; x <= 4; x += 0.1) {
      for (double y = -4; y <= 4; y += 0.1) points.emplace_back(x, y, 10);
    }
    view.width = view.height = 500;
    view.fx = view.fy = 500;
    view.cx = view.cy = 250;
  }
};

TEST_CASE("what lies behind a nearer surface is not seen, what lies beside it is") {
  const TwoWalls walls;
  const auto seen = estimated_views(walls.points, {}, std::vector{walls.view}, [] {});
  REQUIRE(seen.size() == walls.points.size());
  for (std::size_t i = 0; i < walls.points.size(); ++i) {
    const glm::dvec2 slope = glm::abs(glm::dvec2(walls.points[i]) / walls.points[i].z);
    const double from_edge = std::max(slope.x, slope.y) - 0.25;  // of the shadow of the nearer wall
    CAPTURE(i, from_edge);
    if (i < walls.first_behind || from_edge > 0.06) CHECK(seen[i] == std::vector<std::uint32_t>{0});
    if (i >= walls.first_behind && from_edge < 0) CHECK(seen[i].empty());
  }
}

TEST_CASE("a point that faces away is not seen, one without a normal is") {
  const TwoWalls walls;
  std::vector<glm::vec3> normals(walls.points.size(), glm::vec3(0, 0, -1));
  normals[0] = {0, 0, 1};
  normals[1] = {0, 0, 0};
  const auto seen = estimated_views(walls.points, normals, std::vector{walls.view}, [] {});
  CHECK(seen[0].empty());
  CHECK(seen[1].size() == 1);
  CHECK(seen[2].size() == 1);
}

TEST_CASE("points behind the camera and beside its picture are not seen") {
  const TwoWalls walls;
  const std::vector<glm::dvec3> points{{0, 0, -4}, {0, 0, 0}, {9, 0, 4}, {0, 0, 4}};
  const auto seen = estimated_views(points, {}, std::vector{walls.view}, [] {});
  CHECK(seen[0].empty());
  CHECK(seen[1].empty());
  CHECK(seen[2].empty());
  CHECK(seen[3].size() == 1);
  CHECK(estimated_views({}, {}, std::vector{walls.view}, [] {}).empty());
}

TEST_CASE("of many views the number that the rule gives is kept, ascending, the first among them") {
  const TwoWalls walls;
  std::size_t looked = 0;
  std::mutex counting;
  const auto seen = estimated_views(walls.points, {}, std::vector(50, walls.view), [&] {
    const std::lock_guard lock(counting);
    ++looked;
  });
  CHECK(looked == 50);
  REQUIRE(seen[5].size() == kMostEstimatedViews);
  CHECK(std::is_sorted(seen[5].begin(), seen[5].end()));
  CHECK(seen[5].front() == 0);
  CHECK(seen[5].back() >= 45);
}

TEST_CASE("a sphere's points are given to views on their side") {
  const std::vector<glm::dvec3> points = sphere_points(4000);
  const std::vector<Camera> views = views_around(10);
  const auto seen = estimated_views(points, {}, views, [] {});
  std::size_t right = 0, wrong = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (const std::uint32_t view : seen[i]) {
      ++(glm::dot(views[view].center() - points[i], points[i]) > 0 ? right : wrong);
    }
  }
  CHECK(right > 10000);
  CHECK(wrong * 25 < right);  // at the silhouette, where depths before and behind it are nearly the same
}

}  // namespace
}  // namespace lumatlas
