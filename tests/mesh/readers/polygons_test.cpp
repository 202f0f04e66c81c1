// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/readers/polygons.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <numeric>

namespace lumatlas {
namespace {

using FaceList = std::vector<glm::uvec3>;
using Points = std::vector<glm::dvec3>;

// One polygon through these points in their order.
TriangleSoup fanned(const Points& points, Polygons& polygons) {
  std::vector<std::uint32_t> corners(points.size());
  std::iota(corners.begin(), corners.end(), 0u);
  TriangleSoup soup{points, {}, {}};
  polygons.append(corners, soup.faces);
  return soup;
}

TriangleSoup triangulated(const Points& points) {
  Polygons polygons;
  TriangleSoup soup = fanned(points, polygons);
  polygons.triangulate(soup);
  return soup;
}

glm::dvec3 area_vector(const TriangleSoup& soup, const glm::uvec3& face) {
  const glm::dvec3& a = soup.positions[face.x];
  return glm::cross(soup.positions[face.y] - a, soup.positions[face.z] - a) / 2.0;
}

// The sum of the faces' areas, whichever way they turn.
double covered_area(const TriangleSoup& soup) {
  return std::accumulate(soup.faces.begin(), soup.faces.end(), 0.0, [&](double sum, const glm::uvec3& face) {
    return sum + glm::length(area_vector(soup, face));
  });
}

bool all_turn_towards(const TriangleSoup& soup, const glm::dvec3& normal) {
  return std::all_of(soup.faces.begin(), soup.faces.end(),
                     [&](const glm::uvec3& face) { return glm::dot(area_vector(soup, face), normal) > 0; });
}

// A letter U: concave, of area 10, and 14 as a fan.
const Points kU{{0, 0, 0}, {4, 0, 0}, {4, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};

TEST_CASE("a concave polygon is covered once, whichever corner comes first and wherever it faces") {
  Points points = kU;
  for (std::size_t turn = 0; turn < points.size(); ++turn) {
    std::rotate(points.begin(), points.begin() + 1, points.end());
    const TriangleSoup soup = triangulated(points);
    CHECK(soup.faces.size() == 6);
    CHECK(covered_area(soup) == Approx(8));
    CHECK(all_turn_towards(soup, {0, 0, 1}));
  }
  std::reverse(points.begin(), points.end());
  CHECK(all_turn_towards(triangulated(points), {0, 0, -1}));
  for (glm::dvec3& p : points) p = {p.z + 0.3 * p.x, p.x, p.y};  // slanted, seen best along x
  CHECK(covered_area(triangulated(points)) == Approx(8 * std::sqrt(1.09)));
}

TEST_CASE("convex polygons of few corners stay fans") {
  CHECK(triangulated({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}).faces == FaceList{{0, 1, 2}, {0, 2, 3}});
  CHECK(triangulated({{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {2, 2, 0}, {0, 2, 0}}).faces ==
        FaceList{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}});
}

TEST_CASE("a quadrilateral with a dent is cut at the dent") {
  const TriangleSoup soup = triangulated({{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, 0.2, 0}});
  CHECK(covered_area(soup) == Approx(0.8));
  CHECK(all_turn_towards(soup, {0, 0, 1}));
}

TEST_CASE("corners in a line leave no crack and no face without area") {
  const TriangleSoup soup = triangulated({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}});
  CHECK(covered_area(soup) == Approx(4));
  CHECK(all_turn_towards(soup, {0, 0, 1}));  // so that each corner is one of a real face
}

TEST_CASE("a polygon that is not quite plane is covered") {
  Points points = kU;
  for (std::size_t i = 0; i < points.size(); ++i) points[i].z = 0.05 * static_cast<double>(i % 3);
  const TriangleSoup soup = triangulated(points);
  CHECK(covered_area(soup) == Approx(8).epsilon(0.02));
  CHECK(all_turn_towards(soup, {0, 0, 1}));
}

TEST_CASE("a hole that a bridge joins to the outline stays a hole") {
  const Points points{{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {0, 3, 0}, {0, 0, 0},
                      {1, 1, 0}, {1, 2, 0}, {2, 2, 0}, {2, 1, 0}, {1, 1, 0}};
  const TriangleSoup soup = triangulated(points);
  CHECK(soup.faces.size() == 8);
  CHECK(covered_area(soup) == Approx(8));
  CHECK(all_turn_towards(soup, {0, 0, 1}));
}

TEST_CASE("what repeats a corner has a degenerate face for repair() to count") {
  const TriangleSoup soup = triangulated({{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  CHECK(soup.faces.size() == 3);
  CHECK(covered_area(soup) == Approx(1));
}

TEST_CASE("a polygon that touches itself at a corner is covered, and one that does along an edge stays a fan") {
  const TriangleSoup hourglass = triangulated({{0, 0, 0}, {2, 1, 0}, {4, 0, 0}, {4, 4, 0}, {2, 1, 0}, {0, 4, 0}});
  CHECK(hourglass.faces.size() == 4);
  CHECK(covered_area(hourglass) == Approx(8));
  const Points along{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 0, 0}, {0, 4, 0}};  // its fourth corner on its first edge
  CHECK(triangulated(along).faces == FaceList{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}});
}

TEST_CASE("a polygon that crosses itself, has no area or is not finite stays a fan") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Points& points :
       {Points{{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 1, 0}}, Points{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}},
        Points{{0, 0, 0}, {1, 0, 0}, {nan, 0.2, 0}, {0, 1, 0}},
        Points{{-1e308, 0, 0}, {1e308, 0, 0}, {0, 1e307, 0}, {0, 1e308, 0}}}) {
    CHECK(triangulated(points).faces == FaceList{{0, 1, 2}, {0, 2, 3}});
  }
}

TEST_CASE("a polygon of a hundred thousand corners has few long edges, and the same with any number of threads") {
  constexpr std::uint32_t kCorners = 100'000;
  Points points;
  for (std::uint32_t i = 0; i < kCorners; ++i) {
    const double angle = 2 * glm::pi<double>() * i / kCorners;
    points.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  const TriangleSoup soup = triangulated(points);
  CHECK(soup.faces.size() == kCorners - 2);
  CHECK(covered_area(soup) == Approx(glm::pi<double>()).epsilon(1e-6));
  const auto is_long = [&](const glm::uvec3& face) {
    return glm::distance(soup.positions[face.x], soup.positions[face.y]) > 0.1 ||
           glm::distance(soup.positions[face.y], soup.positions[face.z]) > 0.1;
  };
  CHECK(std::count_if(soup.faces.begin(), soup.faces.end(), is_long) < kCorners / 20);  // of the fan, nearly all
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  CHECK(triangulated(points).faces == soup.faces);
}

}  // namespace
}  // namespace lumatlas
