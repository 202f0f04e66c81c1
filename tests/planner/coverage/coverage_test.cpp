// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/coverage/coverage.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <glm/glm.hpp>
#include <limits>
#include <random>

namespace lumatlas {
namespace {

Camera camera_at(const glm::dvec3& center) {
  Camera camera;
  camera.width = 100;
  camera.height = 80;
  camera.fx = camera.fy = 100;
  camera.cx = 50;
  camera.cy = 40;
  camera.cam_from_world_translation = -center;
  return camera;
}

Cell unit_cell() {
  Cell cell;
  cell.area = 1;
  cell.normal = {0, 0, 1};
  cell.radius = 0.7;
  return cell;
}

CoverageOptions options_at(double ideal_distance) {
  CoverageOptions options;
  options.ideal_distance = ideal_distance;
  return options;
}

std::vector<Contribution> random_views(std::mt19937& random, std::size_t count) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Contribution> views;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3 direction(uniform(random), uniform(random), 1.1 + uniform(random));
    views.push_back({glm::normalize(direction), 0.5 + 0.5 * uniform(random)});
  }
  return views;
}

std::vector<SetMember> referenced(std::span<const Contribution> views) {
  std::vector<SetMember> members;
  for (const Contribution& view : views) members.push_back({view, true});
  return members;
}

CoverageOptions printed_at(double ideal_distance) {
  CoverageOptions options = CoverageOptions::printed();
  options.ideal_distance = ideal_distance;
  return options;
}

// cov(f, b) of the last of the views against those before it.
double newcomer_coverage(std::span<const Contribution> views, CoverageOptions options) {
  options.max_cell_coverage = 1e6;  // a clamp would hide what it adds
  return set_coverage(referenced(views), true, options) -
         set_coverage(referenced(views.first(views.size() - 1)), false, options);
}

TEST_CASE("coverage is in [0, 1] for any views") {
  std::mt19937 random(7);
  for (int round = 0; round < 500; ++round) {
    CoverageOptions options = options_at(2);
    options.max_references = 1 + static_cast<std::uint32_t>(random() % 40);
    options.lambda = static_cast<double>(random() % 11) / 10.0;
    const std::vector<Contribution> views = random_views(random, 1 + random() % 20);
    const double cov = newcomer_coverage(views, options);
    CHECK(cov >= -1e-12);  // a difference of sums
    CHECK(cov <= 1 + 1e-12);
    const double sum = set_coverage(referenced(views), false, options);
    CHECK(sum >= 0);
    CHECK(sum <= options.max_references / 2.0);
  }
}

TEST_CASE("the bound on the angle is finite for every number of references and rises with it") {
  for (const bool hemisphere : {true, false}) {
    CoverageOptions options = options_at(1);
    options.departures.hemisphere = hemisphere;
    double before = -1.1;
    for (std::uint32_t references = 1; references <= 100; ++references) {
      options.max_references = references;
      const double bound = tammes_cosine_bound(options);
      CHECK(bound >= before);
      CHECK(bound >= -1);
      CHECK(bound < 1);
      before = bound;
    }
  }
  CoverageOptions options = options_at(1);
  options.max_references = 16;
  CHECK(tammes_cosine_bound(options) == Approx(2 * std::pow(1 - 1.0 / 16, 2) - 1));  // DESIGN: the hemisphere
  options.departures.hemisphere = false;
  CHECK(tammes_cosine_bound(options) == Approx(2 * std::pow(1 - 2.0 / 16, 2) - 1));  // section 3.2, as printed
}

TEST_CASE("an empty cell gives its first view all directional coverage, as printed none") {
  CoverageOptions options = options_at(1);
  CHECK(directional_coverage(-1, true, options) == 1);
  options.departures.first_view = false;
  CHECK(directional_coverage(-1, true, options) == 0);
}

TEST_CASE("coverage never grows when a direction is added to the others") {
  std::mt19937 random(3);
  for (int round = 0; round < 300; ++round) {
    const CoverageOptions options = options_at(2);
    const std::vector<Contribution> views = random_views(random, 12);
    double before = 2;
    for (std::size_t others = 0; others < 11; ++others) {
      std::vector<Contribution> compared(views.begin(), views.begin() + static_cast<std::ptrdiff_t>(others));
      compared.push_back(views[11]);
      const double now = newcomer_coverage(compared, options);
      CHECK(now <= before + 1e-12);
      before = now;
    }
  }
}

TEST_CASE("coverage is the same when cell, camera and lengths are all scaled") {
  const double scale = 1234.5;
  Cell cell = unit_cell();
  cell.centroid = {0.1, 0.2, 0.3};
  Cell large = cell;
  large.centroid *= scale;
  large.area *= scale * scale;
  const Contribution small_part = contribution(cell, 1.2, camera_at({1, 2, 3}), 100, options_at(2));
  const Contribution large_part =
      contribution(large, 1.2 * scale, camera_at(glm::dvec3(1, 2, 3) * scale), 100, options_at(2 * scale));
  CHECK(large_part.positional == Approx(small_part.positional));
  CHECK(glm::length(large_part.direction - small_part.direction) < 1e-12);
}

TEST_CASE("positional coverage equals a hand-worked table") {
  const Cell cell = unit_cell();
  // At distance 2 a unit area fills fx fy / 4 = 2500 pixels; half of them visible, at the ideal distance.
  CHECK(contribution(cell, 1, camera_at({0, 0, 2}), 1250, options_at(2)).positional == Approx(0.5));
  // One sigma (half the ideal distance, 1) away: exp(-1/2); at distance 3 it fills 10000 / 9 pixels.
  CHECK(contribution(cell, 1, camera_at({0, 0, 3}), 10000.0 / 9, options_at(2)).positional == Approx(std::exp(-0.5)));
  // No more than wholly visible; as printed more.
  CHECK(contribution(cell, 1, camera_at({0, 0, 2}), 5000, options_at(2)).positional == Approx(1));
  CHECK(contribution(cell, 1, camera_at({0, 0, 2}), 5000, printed_at(2)).positional == Approx(2));
  // A cell of less than a pixel counts as one pixel; one larger than a cell's face as that face.
  Cell tiny = cell;
  tiny.area = 1e-9;
  CHECK(contribution(tiny, 1, camera_at({0, 0, 2}), 1, options_at(2)).positional == Approx(1));
  Cell large = cell;
  large.area = 100;
  CHECK(contribution(large, 1, camera_at({0, 0, 2}), 1250, options_at(2)).positional == Approx(0.5));
}

TEST_CASE("a camera at the centroid covers nothing") {
  const Contribution part = contribution(unit_cell(), 1, camera_at({0, 0, 0}), 100, options_at(2));
  CHECK(part.positional == 0);
  CHECK(std::isfinite(part.direction.x));
}

TEST_CASE("two opposite views cover more than two alike") {
  CoverageOptions options = options_at(1);
  options.lambda = 0.4;
  const Contribution up{{0, 0, 1}, 0.5};
  const Contribution side{{1, 0, 0}, 0.5};
  CHECK(set_coverage(referenced(std::vector{up, side}), false, options) == Approx(2 * (0.4 + 0.6 * 0.5)));
  CHECK(set_coverage(referenced(std::vector{up, up}), false, options) == Approx(0.4 + 2 * 0.6 * 0.5));
  CHECK(set_coverage({}, false, options) == 0);
}

TEST_CASE("a set's coverage never falls when a view joins it") {
  std::mt19937 random(11);
  for (int round = 0; round < 300; ++round) {
    const std::vector<Contribution> views = random_views(random, 20);
    double before = 0;
    for (std::size_t count = 0; count <= views.size(); ++count) {
      const double now = set_coverage(referenced(std::span(views).first(count)), false, options_at(2));
      CHECK(now >= before);
      before = now;
    }
  }
}

TEST_CASE("printed, a referenced view has no directional coverage, but a newcomer and a view without a place have") {
  CoverageOptions options = printed_at(1);
  options.lambda = 0.4;
  const Contribution up{{0, 0, 1}, 0.5};
  const Contribution side{{1, 0, 0}, 0.5};
  const double positional = 0.6 * 0.5;
  CHECK(set_coverage(referenced(std::vector{up, side}), false, options) == Approx(2 * positional));
  CHECK(set_coverage(referenced(std::vector{up, side}), true, options) == Approx(2 * positional + 0.4));
  const std::vector<SetMember> without_a_place{{up, true}, {side, false}};
  CHECK(set_coverage(without_a_place, false, options) == Approx(2 * positional + 0.4));
}

// Each departure by itself, on a cell of two references at right angles, a third beside the first, and one that the
// cell sees but does not refer to; R_max = 16, lambda = 0.4, cov_p = 0.5, worked by hand.
TEST_CASE("each departure from the print can be switched by itself") {
  CoverageOptions options = printed_at(1);
  options.lambda = 0.4;
  const Contribution up{{0, 0, 1}, 0.5};
  const Contribution side{{1, 0, 0}, 0.5};
  const std::vector<SetMember> members{{up, true}, {side, true}, {up, true}, {side, false}};
  const double positional = 0.6 * 0.5;
  const auto fcov = [&] { return set_coverage(members, false, options); };
  CHECK(fcov() == Approx(4 * positional));  // every view is itself in R(b), or at the place of one that is
  options.departures.references = true;
  CHECK(fcov() == Approx(3 * positional));
  // The second stands at right angles to those before it: 1; the third where the first stands: 0; the first alone: as
  // printed 0.
  options.departures.comparison = CoverageDepartures::Comparison::earlier;
  CHECK(fcov() == Approx(3 * positional + 0.4));
  options.departures.first_view = true;
  CHECK(fcov() == Approx(3 * positional + 2 * 0.4));
  // Leaving each one out: first and third see each other, only the second stands alone.
  options.departures.comparison = CoverageDepartures::Comparison::others;
  CHECK(fcov() == Approx(3 * positional + 0.4));
  // On the sphere 1 - cos theta(16) = 2 - 2 (7/8)^2 = 15/32, on the hemisphere 2 - 2 (15/16)^2 = 31/128; 20 degrees.
  const double near = std::cos(glm::radians(20.0));
  options.departures.hemisphere = false;
  CHECK(directional_coverage(near, false, options) == Approx((1 - near) * 32 / 15));
  options.departures.hemisphere = true;
  CHECK(directional_coverage(near, false, options) == Approx((1 - near) * 128 / 31));
}

TEST_CASE("a repeated view adds nothing directional") {
  for (const auto comparison : {CoverageDepartures::Comparison::earlier, CoverageDepartures::Comparison::everyone}) {
    CoverageOptions options = options_at(1);
    options.departures.comparison = comparison;
    options.lambda = 1;
    std::mt19937 random(5);
    std::vector<Contribution> views = random_views(random, 6);
    const double before = set_coverage(referenced(views), false, options);
    views.push_back(views[2]);
    CHECK(set_coverage(referenced(views), true, options) == Approx(before).margin(1e-12));
  }
}

TEST_CASE("coverage is the same after a rigid motion of cell and camera") {
  const glm::dmat3 turn(glm::rotate(glm::dmat4(1), 1.1, glm::normalize(glm::dvec3(1, -2, 0.5))));
  const glm::dvec3 shift(10, -20, 30);
  Cell cell = unit_cell();
  cell.centroid = {0.1, 0.2, 0.3};
  Cell moved = cell;
  moved.centroid = turn * cell.centroid + shift;
  moved.normal = turn * cell.normal;
  const glm::dvec3 center(1, 2, 3);
  const Contribution part = contribution(cell, 1.2, camera_at(center), 100, options_at(2));
  const Contribution moved_part = contribution(moved, 1.2, camera_at(turn * center + shift), 100, options_at(2));
  CHECK(moved_part.positional == Approx(part.positional));
  CHECK(glm::length(moved_part.direction - turn * part.direction) < 1e-12);
}

TEST_CASE("coverage options that break a rule are refused by name") {
  CoverageOptions options = options_at(1);
  CHECK_NOTHROW(check(options));
  options.lambda = 1.5;
  CHECK_THROWS_WITH(check(options), Catch::Contains("lambda is 1.5") && Catch::Contains("[0, 1]"));
  options = options_at(std::numeric_limits<double>::quiet_NaN());
  CHECK_THROWS_WITH(check(options), Catch::Contains("ideal_distance"));
  options = options_at(1);
  options.demand_prior = -1;
  CHECK_THROWS_WITH(check(options), Catch::Contains("demand_prior is -1"));
  options = options_at(1);
  options.max_references = 0;
  CHECK_THROWS_WITH(check(options), Catch::Contains("max_references"));
  options = options_at(1);
  options.directions = 0;
  CHECK_THROWS_WITH(check(options), Catch::Contains("directions is 0"));
  options = options_at(1);
  options.direction_width = 0;
  CHECK_THROWS_WITH(check(options), Catch::Contains("direction_width"));
  options = options_at(1);
  options.views_per_direction = 9;
  CHECK_THROWS_WITH(check(options), Catch::Contains("views_per_direction is 9"));
}

}  // namespace
}  // namespace lumatlas
