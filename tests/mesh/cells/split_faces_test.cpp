// SPDX-License-Identifier: GPL-3.0-or-later
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "mesh/cells/split_faces.h"
#include "tests/support/scenes/surfaces.h"
#include "tests/support/skip.h"

namespace lumatlas {
namespace {

TEST_CASE("splitting a wall of two triangles keeps its area and bounds every edge") {
  const Mesh wall = plane(1, 10);
  for (const double max_edge : {20.0, 10.0, 3.0, 1.0, 0.37}) {
    const Mesh split = split_large_faces(wall, max_edge);
    CHECK(longest_edge_of(split) <= max_edge);
    CHECK(area_of(split) == Approx(100).epsilon(1e-6));  // corners are floats
    CHECK(is_manifold_and_oriented(split));
    // Halving makes no edge shorter than half of the limit on the outline.
    CHECK(static_cast<double>(boundary_edges(split)) <= 4 * std::ceil(10 / (max_edge / 2)));
  }
}

TEST_CASE("the faces that a split makes are forecast from below, and by no more than a factor of four") {
  for (const double max_edge : {20.0, 3.0, 1.0, 0.37, 0.05}) {
    const Mesh wall = plane(1, 10);
    const double forecast = fewest_split_faces(wall, max_edge);
    const auto faces = static_cast<double>(split_large_faces(wall, max_edge).faces.size());
    CHECK(forecast <= faces);
    CHECK(4 * forecast >= faces);
  }
  CHECK(fewest_split_faces(plane(1, 1), 1e-5) == Approx(2.3094e10));
  CHECK_THROWS_AS(fewest_split_faces(plane(1, 1), 0), std::invalid_argument);
}

TEST_CASE("split faces have their colours interpolated without drift") {
  const Mesh split = split_large_faces(plane(1, 1), 0.02);
  REQUIRE(split.colors.size() == split.positions.size());
  for (std::size_t i = 0; i < split.positions.size(); ++i) {
    CHECK(split.colors[i].r == std::lround(255 * split.positions[i].x));
    CHECK(split.colors[i].g == std::lround(255 * split.positions[i].y));
    CHECK(split.colors[i].b == 0);
  }
}

TEST_CASE("a mesh without long edges is returned as it is") {
  const Mesh mesh = plane(10, 1);
  const Mesh same = split_large_faces(mesh, 0.2);
  CHECK(same.positions == mesh.positions);
  CHECK(same.colors == mesh.colors);
  CHECK(same.faces == mesh.faces);
}

TEST_CASE("splitting a closed surface leaves it closed and its volume as it was") {
  const Mesh coarse = joined(sphere(1), moved(sphere(0), {4, 0, 0}));
  const Mesh split = split_large_faces(coarse, 0.1);
  CHECK(longest_edge_of(split) <= 0.1);
  CHECK(boundary_edges(split) == 0);
  CHECK(is_manifold_and_oriented(split));
  CHECK(split.colors.empty());
  CHECK(area_of(split) == Approx(area_of(coarse)).epsilon(1e-6));
  CHECK(volume_of(split) == Approx(volume_of(coarse)).epsilon(1e-6));
}

TEST_CASE("splitting touches only what is long and what lies beside it") {
  const Mesh mesh = joined(plane(20, 1), moved(plane(1, 1), {2, 0, 0}));
  const Mesh split = split_large_faces(mesh, 0.3);
  for (std::size_t i = 0; i < 800; ++i) CHECK(split.faces[i] == mesh.faces[i]);
}

TEST_CASE("longest-edge bisection makes no needles") {
  const Mesh split = split_large_faces(sphere(0), 0.05);
  double smallest_sine = 1;
  for (const glm::uvec3& face : split.faces) {
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 at(split.positions[face[corner]]);
      const glm::dvec3 u = glm::normalize(glm::dvec3(split.positions[face[(corner + 1) % 3]]) - at);
      const glm::dvec3 v = glm::normalize(glm::dvec3(split.positions[face[(corner + 2) % 3]]) - at);
      smallest_sine = std::min(smallest_sine, glm::length(glm::cross(u, v)));
    }
  }
  CHECK(smallest_sine > std::sin(glm::radians(29.0)));  // half of an equilateral face's 60 degrees
}

TEST_CASE("max_edge must be positive") {
  const Mesh mesh = plane(1, 1);
  CHECK_THROWS_MATCHES(split_large_faces(mesh, 0), std::invalid_argument,
                       Catch::Message("max_edge: is 0, must be finite and above 0"));
  CHECK_THROWS_MATCHES(split_large_faces(mesh, -2), std::invalid_argument,
                       Catch::Message("max_edge: is -2, must be finite and above 0"));
  CHECK_THROWS_AS(split_large_faces(mesh, std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  CHECK_THROWS_AS(split_large_faces(mesh, std::numeric_limits<double>::infinity()), std::invalid_argument);
}

TEST_CASE("a max_edge that no split can reach or no memory hold is refused") {
  const Mesh far = moved(plane(1, 1), {1e6f, 0, 0});  // floats are 1/16 apart there
  CHECK_THROWS_MATCHES(split_large_faces(far, 0.01), std::invalid_argument,
                       Catch::Message("max_edge: is 0.01, must be at least 0.25, four times the resolution of the "
                                      "positions of the faces to be split"));
  CHECK(longest_edge_of(split_large_faces(far, 0.25)) <= 0.25);
  CHECK_THROWS_MATCHES(split_large_faces(plane(1, 1), 1e-5), std::invalid_argument,
                       Catch::Predicate<std::invalid_argument>([](const std::invalid_argument& error) {
                         return std::string(error.what())
                             .starts_with(
                                 "max_edge: is 1e-05, must be larger: it would split the mesh into at least "
                                 "2.3094e+10 faces, and this machine has memory for ");
                       }));
}

// Returns the edge of equilateral faces if the area of 1 is divided among this number of them.
double edge_of(double faces) {
  return std::sqrt(4 / (std::sqrt(3.0) * faces));
}

TEST_CASE("a refusal names fewer faces as the limit than the split would make") {
  const auto faces_and_limit = [](double max_edge) -> std::pair<double, double> {
    struct Began {};
    try {
      (void)split_large_faces(plane(1, 1), max_edge, [] { throw Began(); });
    } catch (const Began&) {
      return {0, 0};
    } catch (const std::invalid_argument& error) {
      const std::string message = error.what();
      const auto number_after = [&](const std::string& words) {
        const std::size_t at = message.find(words);
        REQUIRE(at != std::string::npos);
        return std::stod(message.substr(at + words.size()));
      };
      return {number_after("at least "), number_after("memory for ")};
    }
    return {0, 0};
  };
  const double limit = faces_and_limit(1e-5).second;
  REQUIRE(limit > 0);
  for (const double share : {0.3, 0.9, 1.1, 3.0}) {
    CAPTURE(share);
    const auto [faces, named] = faces_and_limit(edge_of(share * limit));
    CHECK((faces > 0) == (share > 1));
    CHECK((faces == 0 || faces > named));
  }
}

TEST_CASE("a mesh may be split into more than four million faces where memory holds them") {
  const double memory = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  if (memory < 16e9) return skip("needs a machine with 16 GB");
  struct Began {};
  CHECK_THROWS_AS(split_large_faces(plane(1, 1), edge_of(4.5e6), [] { throw Began(); }), Began);
}

TEST_CASE("a mesh that is not manifold is split without a crack") {
  const Mesh fins{{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}}, {}, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}};
  const Mesh split = split_large_faces(fins, 0.2);
  CHECK(longest_edge_of(split) <= 0.2);
  CHECK(area_of(split) == Approx(1.5).epsilon(1e-6));
  // Points on the edge that all three share have the same positions on each.
  std::map<float, int> copies;
  for (const glm::vec3& p : split.positions) {
    if (p.x == 0 && p.y == 0 && p.z > 0 && p.z < 1) ++copies[p.z];
  }
  CHECK(copies.size() == 7);
  for (const auto& [z, count] : copies) CHECK(count == 3);
}

// A disc around the origin as a fan around its centre.
Mesh fan(std::uint32_t corners, double radius) {
  Mesh mesh{{{0, 0, 0}}, {}, {}};
  for (std::uint32_t i = 0; i < corners; ++i) {
    const double angle = 2 * glm::pi<double>() * i / corners;
    mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
    mesh.faces.emplace_back(0, 1 + i, 1 + (i + 1) % corners);
  }
  return mesh;
}

TEST_CASE("a fan of needles is split as any face while that takes few faces") {
  const Mesh split = split_large_faces(fan(1000, 10), 1);
  CHECK(longest_edge_of(split) <= 1);
  CHECK(is_manifold_and_oriented(split));
}

TEST_CASE("a fan of a hundred thousand needles does not become more faces than memory holds") {
  const Mesh disc = fan(100'000, 30);  // without a bound, 12.9 million faces
  const Mesh split = split_large_faces(disc, 1);
  CHECK(split.faces.size() == disc.faces.size() + 2 * 1'000'000);
  CHECK(longest_edge_of(split) < 8);
  CHECK(area_of(split) == Approx(area_of(disc)).epsilon(1e-4));
}

TEST_CASE("the faces at a stray vertex are not split, and stop no other") {
  Mesh mesh = joined(plane(20, 1), moved(plane(1, 1), {2, 0, 0}));
  mesh.positions[0] = {-1e8f, 0, 0};
  const Mesh split = split_large_faces(mesh, 0.1);
  CHECK(split.faces.size() < mesh.faces.size() + 1000);
  Mesh rest = split;
  std::erase_if(rest.faces, [](const glm::uvec3& face) { return face.x == 0 || face.y == 0 || face.z == 0; });
  CHECK(longest_edge_of(rest) < 1);
  CHECK(area_of(rest) == Approx(2).epsilon(0.01));
}

TEST_CASE("splitting ends when its cancel_check throws") {
  int checks = 0;
  const CancelCheck cancel_check = [&] {
    if (++checks == 3) throw std::runtime_error("enough");
  };
  CHECK_THROWS_WITH(split_large_faces(plane(1, 1), 0.01, cancel_check), "enough");
  CHECK(checks == 3);
}

}  // namespace
}  // namespace lumatlas
