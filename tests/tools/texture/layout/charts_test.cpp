// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/layout/charts.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numbers>
#include <random>

#include "tests/support/refusal.h"
#include "tests/support/scenes/surfaces.h"

namespace lumatlas {
namespace {

using glm::dvec2;
using glm::dvec3;
using FlatFace = std::array<dvec2, 3>;

Cells cells_of(const Mesh& mesh, double size) {
  CellOptions options;
  options.size = size;
  return make_cells(mesh, options);
}

FlatFace flat_face(const Mesh& mesh, const Chart& chart, std::uint32_t face) {
  FlatFace flat;
  for (int c = 0; c < 3; ++c) {
    flat[static_cast<std::size_t>(c)] = chart.place(dvec3(mesh.positions[mesh.faces[face][c]]));
  }
  return flat;
}

// Turning from the first axis to the second, twice.
double turn(const dvec2& a, const dvec2& b, const dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// How far two triangles reach into each other, as a length: over all edges of both, the least depth of the other one
// behind the edge. Places on a chart are clockwise, for its second axis points down.
double overlap(const FlatFace& a, const FlatFace& b) {
  double least = std::numeric_limits<double>::infinity();
  const auto look = [&](const FlatFace& from, const FlatFace& to) {
    for (std::size_t i = 0; i < 3; ++i) {
      const dvec2 p = from[i], q = from[(i + 1) % 3];
      const double length = glm::distance(p, q);
      double deepest = -std::numeric_limits<double>::infinity();
      for (const dvec2& corner : to) deepest = std::max(deepest, -turn(p, q, corner) / length);
      least = std::min(least, deepest);
    }
  };
  look(a, b);
  look(b, a);
  return least;
}

// Everything that charts.h promises of every mesh.
void check_charts(const Mesh& mesh, const std::vector<Chart>& charts, const ChartOptions& options) {
  std::vector<int> charts_of_face(mesh.faces.size(), 0);
  const double least_cosine = std::cos(glm::radians(options.most_degrees));
  for (const Chart& chart : charts) {
    CHECK(std::abs(glm::dot(chart.right, chart.down)) < 1e-9);
    CHECK(chart.size.x >= chart.size.y - 1e-9);
    for (const std::uint32_t face : chart.faces) {
      ++charts_of_face[face];
      const glm::uvec3& f = mesh.faces[face];
      const dvec3 a(mesh.positions[f.x]), b(mesh.positions[f.y]), c(mesh.positions[f.z]);
      const double area = glm::length(glm::cross(b - a, c - a));
      const FlatFace flat = flat_face(mesh, chart, face);
      const double flat_area = -turn(flat[0], flat[1], flat[2]);
      // Area and angles: a projection along a direction within most_degrees of the normal.
      REQUIRE(flat_area >= (least_cosine - 1e-6) * area);
      REQUIRE(flat_area <= (1 + 1e-6) * area);
      for (std::size_t i = 0; i < 3; ++i) {
        const dvec3 p(mesh.positions[f[static_cast<int>(i)]]), q(mesh.positions[f[static_cast<int>((i + 1) % 3)]]);
        const double length = glm::distance(p, q), flat_length = glm::distance(flat[i], flat[(i + 1) % 3]);
        REQUIRE(flat_length <= (1 + 1e-6) * length);
        REQUIRE(flat_length >= (least_cosine - 1e-6) * length);
        REQUIRE(flat[i].x >= -1e-6);
        REQUIRE(flat[i].y >= -1e-6);
        REQUIRE(flat[i].x <= chart.size.x + 1e-6);
        REQUIRE(flat[i].y <= chart.size.y + 1e-6);
      }
    }
    double deepest = 0;
    for (std::size_t i = 0; i < chart.faces.size(); ++i) {
      for (std::size_t k = i + 1; k < chart.faces.size(); ++k) {
        deepest =
            std::max(deepest, overlap(flat_face(mesh, chart, chart.faces[i]), flat_face(mesh, chart, chart.faces[k])));
      }
    }
    CHECK(deepest < 1e-6);  // positions are floats
  }
  for (const int count : charts_of_face) REQUIRE(count == 1);
}

// A strip around the z axis, `turns` times, rising by `height` a turn: seen from above it lies over itself.
Mesh spiral_ramp(double turns, double height) {
  Mesh mesh;
  constexpr std::uint32_t kSteps = 24;
  const auto steps = static_cast<std::uint32_t>(turns * kSteps);
  for (std::uint32_t i = 0; i <= steps; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSteps, z = height * i / kSteps;
    for (const double radius : {1.0, 2.0}) {
      mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
    if (i == 0) continue;
    const std::uint32_t at = 2 * i;
    mesh.faces.emplace_back(at - 2, at - 1, at);
    mesh.faces.emplace_back(at, at - 1, at + 1);
  }
  return mesh;
}

Mesh crumpled(Mesh mesh, float by, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> offset(-by, by);
  for (glm::vec3& p : mesh.positions) {
    for (int c = 0; c < 3; ++c) p[c] += offset(random);
  }
  return mesh;
}

TEST_CASE("a plane becomes one chart, as large as it is") {
  const Mesh mesh = plane(12, 3);
  const std::vector<Chart> charts = make_charts(mesh, cells_of(mesh, 1));
  REQUIRE(charts.size() == 1);
  CHECK(charts[0].size.x == Approx(3));
  CHECK(charts[0].size.y == Approx(3));
  check_charts(mesh, charts, {});
}

TEST_CASE("a box has a chart for each side") {
  const Mesh mesh = box(6, {3, 2, 1});
  const std::vector<Chart> charts = make_charts(mesh, cells_of(mesh, 0.8));
  CHECK(charts.size() == 6);
  check_charts(mesh, charts, {});
}

TEST_CASE("a sphere's charts keep their bounds, and are few") {
  const Mesh mesh = sphere(4);
  const std::vector<Chart> charts = make_charts(mesh, cells_of(mesh, 0.25));
  CHECK(charts.size() >= 6);
  CHECK(charts.size() <= 40);
  check_charts(mesh, charts, {});
}

TEST_CASE("a ramp that winds over itself is cut where it would overlap") {
  const Mesh mesh = spiral_ramp(3, 0.4);
  ChartOptions options;
  options.reach = 100;
  const std::vector<Chart> charts = make_charts(mesh, cells_of(mesh, 0.7), options);
  CHECK(charts.size() >= 3);
  check_charts(mesh, charts, options);
}

TEST_CASE("rough surfaces keep the bounds face by face") {
  ChartOptions options;
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    const Mesh mesh = crumpled(plane(20, 2), 0.06f, seed);  // normals up to 80 degrees off
    check_charts(mesh, make_charts(mesh, cells_of(mesh, 0.5), options), options);
    const Mesh ball = crumpled(sphere(3), 0.1f, seed);
    check_charts(ball, make_charts(ball, cells_of(ball, 0.5), options), options);
  }
  options.most_degrees = 50;
  const Mesh mesh = crumpled(plane(20, 2), 0.05f, 4);
  check_charts(mesh, make_charts(mesh, cells_of(mesh, 0.5), options), options);
}

TEST_CASE("the two sides of a sheet have charts of their own") {
  const Mesh sheet = plane(4, 1);
  const Mesh apart = joined(sheet, moved(turned_inside_out(sheet), {0, 0, -0.05f}));
  CHECK(make_charts(apart, cells_of(apart, 0.5)).size() == 2);
  const Mesh at_one_place = joined(sheet, turned_inside_out(sheet));  // four faces meet at each edge
  check_charts(at_one_place, make_charts(at_one_place, cells_of(at_one_place, 0.5)), {});
}

TEST_CASE("chart options are refused by name") {
  using Options = ChartOptions;
  CHECK(refusal<Options>([](Options&) {}) == "accepted");
  CHECK(refusal<Options>([](Options& o) { o.merge_degrees = 81; }) ==
        "charts: merge_degrees is 81, must be in [0, 80]");
  CHECK(refusal<Options>([](Options& o) { o.most_degrees = 20; }) == "charts: most_degrees is 20, must be in [30, 85]");
  CHECK(refusal<Options>([](Options& o) { o.reach = -1; }) == "charts: reach is -1, must be in [0, 1000000]");
  const Mesh mesh = plane(2, 1);
  CHECK_THROWS_WITH(make_charts(mesh, cells_of(sphere(1), 1)),
                    "charts: cells are of 32 faces, must be of the mesh's 8");
}

}  // namespace
}  // namespace lumatlas
