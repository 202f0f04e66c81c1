// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/coverage.h"

#include <catch2/catch.hpp>
#include <cmath>
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

TEST_CASE("coverage is in [0, 1] for any views") {
  std::mt19937 random(7);
  for (int round = 0; round < 500; ++round) {
    CoverageOptions options = options_at(2);
    options.max_references = 1 + static_cast<std::uint32_t>(random() % 40);
    options.lambda = static_cast<double>(random() % 11) / 10.0;
    const std::vector<Contribution> views = random_views(random, 1 + random() % 20);
    const double cov = coverage(views[0], std::span(views).subspan(1), options);
    CHECK(cov >= 0);
    CHECK(cov <= 1);
    const double sum = set_coverage(views, options);
    CHECK(sum >= 0);
    CHECK(sum <= options.max_references / 2.0);
  }
}

TEST_CASE("the bound on the angle is finite for every number of references and rises with it") {
  for (const auto metric : {CoverageOptions::Metric::departures, CoverageOptions::Metric::printed}) {
    CoverageOptions options = options_at(1);
    options.metric = metric;
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
  options.metric = CoverageOptions::Metric::printed;
  CHECK(tammes_cosine_bound(options) == Approx(2 * std::pow(1 - 2.0 / 16, 2) - 1));  // section 3.2, as printed
}

TEST_CASE("an empty cell gives its first view all directional coverage, as printed none") {
  CoverageOptions options = options_at(1);
  CHECK(directional_coverage(-1, true, options) == 1);
  options.metric = CoverageOptions::Metric::printed;
  CHECK(directional_coverage(-1, true, options) == 0);
}

TEST_CASE("coverage never grows when a direction is added to the others") {
  std::mt19937 random(3);
  for (int round = 0; round < 300; ++round) {
    const CoverageOptions options = options_at(2);
    const std::vector<Contribution> views = random_views(random, 12);
    double before = 2;
    for (std::size_t others = 0; others < 11; ++others) {
      const double now = coverage(views[11], std::span(views).first(others), options);
      CHECK(now <= before);
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
  CoverageOptions printed = CoverageOptions::printed();
  printed.ideal_distance = 2;
  CHECK(contribution(cell, 1, camera_at({0, 0, 2}), 5000, printed).positional == Approx(2));
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
  CHECK(set_coverage(std::vector{up, side}, options) == Approx(2 * (0.4 + 0.6 * 0.5)));
  CHECK(set_coverage(std::vector{up, up}, options) == Approx(0.4 + 2 * 0.6 * 0.5));
  CHECK(set_coverage(std::vector<Contribution>{}, options) == 0);
}

TEST_CASE("a set's coverage never falls when a view joins it") {
  std::mt19937 random(11);
  for (int round = 0; round < 300; ++round) {
    const std::vector<Contribution> views = random_views(random, 20);
    double before = 0;
    for (std::size_t count = 0; count <= views.size(); ++count) {
      const double now = set_coverage(std::span(views).first(count), options_at(2));
      CHECK(now >= before);
      before = now;
    }
  }
}

TEST_CASE("printed, a stored view has no directional coverage but a newcomer has") {
  CoverageOptions options = CoverageOptions::printed();
  options.ideal_distance = 1;
  options.lambda = 0.4;
  const std::vector<Contribution> views{{{0, 0, 1}, 0.5}, {{1, 0, 0}, 0.5}};
  CHECK(set_coverage(views, options) == Approx(2 * 0.6 * 0.5));
  CHECK(set_coverage_with_newcomer(views, options) == Approx(2 * 0.6 * 0.5 + 0.4));
}

TEST_CASE("coverage options that break a rule are refused by name") {
  CoverageOptions options = options_at(1);
  CHECK_NOTHROW(check(options));
  options.lambda = 1.5;
  CHECK_THROWS_WITH(check(options), Catch::Contains("lambda is 1.5") && Catch::Contains("[0, 1]"));
  options = options_at(std::numeric_limits<double>::quiet_NaN());
  CHECK_THROWS_WITH(check(options), Catch::Contains("ideal_distance"));
  options = options_at(1);
  options.max_references = 0;
  CHECK_THROWS_WITH(check(options), Catch::Contains("max_references"));
}

}  // namespace
}  // namespace lumatlas
