// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/cut/thinning.h"

#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <stdexcept>

#include "tests/support/scenes/plain_camera.h"
#include "tests/tools/meshing/seen_sphere.h"

namespace lumatlas {
namespace {

ScenePoints points_at(std::vector<glm::dvec3> positions, std::vector<std::vector<std::uint32_t>> views) {
  ScenePoints points;
  points.positions = std::move(positions);
  points.views = std::move(views);
  for (std::size_t i = 0; i < points.positions.size(); ++i) points.colors.emplace_back(static_cast<std::uint8_t>(i));
  return points;
}

TEST_CASE("of points closer than the spacing the one that most views saw stays, with the views of all") {
  const std::vector<Camera> views{plain_camera({0, 0, 0}), plain_camera({0, 0, -10}), plain_camera({0, 0, -20})};
  // A pixel of the nearest view, at depth 10, is 0.1 wide.
  const ScenePoints points =
      points_at({{0, 0, 10}, {0.3, 0, 10}, {1, 0, 10}, {5, 0, 10}}, {{0}, {0, 1, 2}, {0, 1}, {}});
  const ScenePoints thin = thinned(points, views, 4);
  REQUIRE(thin.positions.size() == 2);
  CHECK(thin.positions[0] == glm::dvec3(0.3, 0, 10));
  CHECK(thin.colors[0] == glm::u8vec3(1));
  CHECK(thin.views[0] == std::vector<std::uint32_t>{0, 1, 2});
  CHECK(thin.positions[1] == glm::dvec3(1, 0, 10));
}

TEST_CASE("no two points that are left are closer than the spacing of the nearer one, and none is far from them") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-20, 20);
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 3000; ++i) positions.emplace_back(place(random), place(random), 25 + place(random));
  const std::vector<Camera> views{plain_camera({0, 0, 0})};
  const ScenePoints points = points_at(positions, std::vector(positions.size(), std::vector<std::uint32_t>{0}));
  const ScenePoints thin = thinned(points, views, 10);
  const auto spacing = [](const glm::dvec3& p) { return 10 * glm::length(p) / 100; };
  CHECK(thin.positions.size() < 2000);
  for (std::size_t a = 0; a < thin.positions.size(); ++a) {
    for (std::size_t b = a + 1; b < thin.positions.size(); ++b) {
      const double least = std::min(spacing(thin.positions[a]), spacing(thin.positions[b]));
      CHECK_FALSE(glm::distance(thin.positions[a], thin.positions[b]) < 0.99 * least);
    }
  }
  for (const glm::dvec3& position : positions) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const glm::dvec3& kept : thin.positions) nearest = std::min(nearest, glm::distance(kept, position));
    CHECK(nearest <= spacing(position));
  }
}

TEST_CASE("without a spacing every point that was seen stays") {
  const ScenePoints points = points_at({{0, 0, 1}, {0, 0, 1}, {1e300, -1e300, 3}}, {{0}, {0}, {0}});
  CHECK(thinned(points, std::vector{plain_camera({0, 0, 0})}, 0).positions.size() == 3);
  CHECK_FALSE(
      thinned(points, std::vector{plain_camera({0, 0, 1})}, 2).positions.empty());  // a view at the point itself
  for (const double bad : {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    CHECK_THROWS_AS(thinned(points, std::vector{plain_camera({0, 0, 0})}, bad), std::invalid_argument);
  }
}

}  // namespace
}  // namespace lumatlas
