// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/coverage/direction_coverage.h"

#include <catch2/catch.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/glm.hpp>

#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

// One square of unit area, facing +z.
Surface square(const glm::dmat3& turn = glm::dmat3(1)) {
  Surface surface;
  for (const glm::dvec3 corner : {glm::dvec3(0), glm::dvec3(1, 0, 0), glm::dvec3(1, 1, 0), glm::dvec3(0, 1, 0)}) {
    surface.mesh.positions.emplace_back(turn * corner);
  }
  surface.mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  surface.cells = measure_cells(surface.mesh, {0, 0}, 1);
  return surface;
}

CoverageOptions options_with(std::uint32_t directions, std::uint32_t views) {
  CoverageOptions options;
  options.ideal_distance = 1;
  options.directions = directions;
  options.views_per_direction = views;
  options.max_references = 2;
  options.demand = false;  // what demand does is in cell_demand_test.cpp
  return options;
}

TEST_CASE("novel directions are unit vectors that face the cell, denser where it shows more area") {
  const std::vector<glm::vec3> above = novel_directions(1000, false);
  REQUIRE(above.size() == 1000);
  double mean_z = 0;
  std::size_t steep = 0;
  for (const glm::vec3& direction : above) {
    CHECK(glm::length(direction) == Approx(1).margin(1e-6));
    CHECK(direction.z > 0);
    mean_z += static_cast<double>(direction.z) / 1000;
    steep += direction.z > std::cos(glm::radians(30.0f));
  }
  CHECK(mean_z == Approx(2.0 / 3).margin(0.01));  // of a density of cos theta over the hemisphere
  CHECK(steep == 250);                            // sin^2(30 degrees) of them within 30 degrees of the normal
  glm::dvec3 sum(0);
  for (const glm::vec3& direction : novel_directions(1000, true)) sum += glm::dvec3(direction);
  CHECK(glm::length(sum) < 10);
}

// One novel direction, 45 degrees off the normal; the values are worked by hand from the header's formulas.
TEST_CASE("a cell's value equals one worked by hand") {
  const Surface surface = square();
  CoverageOptions options = options_with(1, 2);
  options.lambda = 0.5;
  options.direction_width = 90;  // k = cos of the angle
  DirectionCoverage coverage(surface, options, 0);
  const glm::dmat3 world_from_cell = glm::transpose(cell_frames(surface)[0].cell_from_world);
  const glm::dvec3 novel = world_from_cell * glm::dvec3(novel_directions(1, false)[0]);
  CHECK(novel.z == Approx(std::sqrt(0.5)));
  const glm::dvec3 normal(0, 0, 1);
  CHECK(coverage.value(0) == 0);
  std::vector<double> losses(3, 0);
  // q = 1 * (0.5 * 1 + 0.5) = 1, counted by 2/3 for the best of two.
  CHECK(coverage.insert(0, 0, {novel, 1}, losses) == Approx(2.0 / 3));
  CHECK(coverage.value(0) == Approx(2.0 / 3));
  // q = 0.8 * (0.5 * cos 45 + 0.5) = 0.68284, second: 1/3.
  CHECK(coverage.insert(0, 1, {normal, 0.8}, losses) == Approx(0.68284 / 3).margin(1e-5));
  CHECK(coverage.value(0) == Approx(2.0 / 3 + 0.68284 / 3).margin(1e-5));
  // A third, of q = 0.9, takes the second place: (0.9 - 0.68284) / 3; if the first had left, both would move up.
  std::vector<double> corrections(3, 0);
  const Contribution third{novel, 0.9};
  const std::vector<std::uint8_t> victims(3, 1);
  CHECK(coverage.gain(0, third, victims, corrections) == Approx((0.9 - 0.68284) / 3).margin(1e-5));
  const double without_first = 2 * 0.9 / 3 + 0.68284 / 3 - 2 * 0.68284 / 3;
  CHECK(corrections[0] == Approx(without_first - (0.9 - 0.68284) / 3).margin(1e-5));
  CHECK(corrections[1] == Approx(0.9 / 3 - (0.9 - 0.68284) / 3).margin(1e-5));
  CHECK(losses[0] == Approx(2.0 / 3 * (1 - 0.68284) + 0.68284 / 3).margin(1e-5));
  CHECK(losses[1] == Approx(0.68284 / 3).margin(1e-5));
  CHECK(coverage.erase(0, 0, losses) == Approx(-2.0 / 3 * (1 - 0.68284) - 0.68284 / 3).margin(1e-5));
  CHECK(losses[0] == Approx(0).margin(1e-9));
  CHECK(losses[1] == Approx(2 * 0.68284 / 3).margin(1e-5));
}

TEST_CASE("a cell's value is the same after a rigid motion, and in [0, 1]") {
  const glm::dmat3 turn(glm::rotate(glm::dmat4(1), 0.9, glm::normalize(glm::dvec3(1, -2, 0.5))));
  DirectionCoverage still(square(), options_with(32, 3), 0);
  DirectionCoverage turned(square(turn), options_with(32, 3), 0);
  for (ViewSlot slot{0}; slot < 12; ++slot) {
    const glm::dvec3 direction = glm::normalize(glm::dvec3(std::sin(slot * 2.1), std::cos(slot * 3.3), 0.2 + slot % 3));
    still.insert(0, slot, {direction, 0.3 + 0.05 * slot});
    turned.insert(0, slot, {turn * direction, 0.3 + 0.05 * slot});
    CHECK(turned.value(0) == Approx(still.value(0)).margin(1e-5));
    CHECK(still.value(0) <= 1);
  }
}

TEST_CASE(
    "a cell's value is at most 1 however narrow the directions, where rounding makes unit vectors longer than 1") {
  for (const double width : {1e-9, 1e-3, 0.1, 1.0, 90.0, 180.0}) {
    CoverageOptions options = options_with(64, 1);
    options.direction_width = width;
    options.lambda = 1;
    const Surface surface = square();
    DirectionCoverage coverage(surface, options, 0);
    const glm::dmat3 world_from_cell = glm::transpose(cell_frames(surface)[0].cell_from_world);
    std::uint32_t slot = 0;
    for (const glm::vec3& direction : novel_directions(64, false)) {
      coverage.insert(0, ViewSlot(slot++), {world_from_cell * glm::dvec3(direction), 1});
    }
    CHECK(coverage.value(0) >= 0);
    CHECK(coverage.value(0) <= 1);
  }
}

TEST_CASE("a cell without a mean normal is served from all around") {
  Surface surface = square();
  // The same square from both sides: the normals cancel.
  surface.mesh.faces = {{0, 1, 2}, {0, 2, 3}, {0, 2, 1}, {0, 3, 2}};
  surface.cells = measure_cells(surface.mesh, {0, 0, 0, 0}, 1);
  REQUIRE(cell_frames(surface)[0].two_sided);
  DirectionCoverage coverage(surface, options_with(64, 1), 0);
  coverage.insert(0, 0, {{0, 0, 1}, 1});
  const double above = coverage.value(0);
  coverage.insert(0, 1, {{0, 0, -1}, 1});
  CHECK(coverage.value(0) > above + 0.02);
}

TEST_CASE("a full cell swaps the reference that is missed least, and takes it back when another leaves") {
  const Surface surface = square();
  CoverageOptions options = options_with(32, 1);
  options.lambda = 1;
  DirectionCoverage coverage(surface, options, 0.001);
  const glm::dvec3 left = glm::normalize(glm::dvec3(-1, 0, 1));
  const glm::dvec3 right = glm::normalize(glm::dvec3(1, 0, 1));
  coverage.insert(0, 0, {left, 0.9});
  coverage.insert(0, 1, {glm::normalize(left + glm::dvec3(0.01, 0, 0)), 0.5});
  CHECK(coverage.references(0) == std::vector<ViewSlot>{0, 1});
  coverage.insert(0, 2, {right, 0.9});
  CHECK(coverage.references(0) == std::vector<ViewSlot>{0, 2});
  coverage.insert(0, 3, {right, 0.9});  // gains nothing
  CHECK(coverage.references(0) == std::vector<ViewSlot>{0, 2});
  coverage.erase(0, 0);
  CHECK(coverage.references(0) == std::vector<ViewSlot>{1, 2});
}

}  // namespace
}  // namespace lumatlas
