// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/paths/camera_tours.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <random>
#include <set>

#include "mesh/upright.h"
#include "tests/support/scenes/small_scenes.h"
#include "tools/picture/paths/spline.h"

namespace lumatlas {
namespace {

using glm::dvec3;

// Returns cameras around a point, all looking at it, on part of a circle, as when a thing on a table is photographed.
std::vector<Camera> around(const dvec3& thing, const dvec3& up, double radius, double height, std::size_t count) {
  const dvec3 u = glm::normalize(glm::cross(up, dvec3(0.3, 0.7, -0.2)));
  const dvec3 v = glm::cross(up, u);
  std::vector<Camera> cameras;
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = 0.3 * static_cast<double>(i);
    const dvec3 position = thing + height * up + radius * (std::cos(angle) * u + std::sin(angle) * v);
    cameras.push_back(camera_at({position, look_at(position, thing, up), 60}, 64, 48));
  }
  return cameras;
}

TEST_CASE("upwards is found from level cameras, however much they look down, whatever the world's axes") {
  for (const dvec3& axis : {dvec3(0, 0, 1), dvec3(0, -1, 0), glm::normalize(dvec3(1, 2, -2))}) {
    CHECK(glm::distance(upward(around({5, 1, 2}, axis, 3, 4, 12)), axis) < 0.002);
  }
  // A single camera leaves all directions at right angles to its x axis open: upwards in its picture.
  const std::vector<Camera> one = around({0, 0, 0}, {0, 0, 1}, 3, 0, 1);
  CHECK(glm::distance(upward(one), dvec3(0, 0, 1)) < 1e-6);
  CHECK_THROWS_WITH(upward({}), "upward: there is no camera, must be at least one");
}

TEST_CASE("an orbit goes once around what the cameras look at, at their distance and height, and closes") {
  const dvec3 thing(5, 1, 2);
  const dvec3 up(0, -1, 0);
  const std::vector<Camera> stored = around(thing, up, 3, 1.5, 9);
  const std::vector<Vantage> frames = orbit(stored, std::hypot(3, 1.5), 24, 50);
  REQUIRE(frames.size() == 24);
  constexpr double kMargin = 0.01;  // upwards is found to a tenth of a degree, from half a circle
  dvec3 mean(0);
  for (std::size_t i = 0; i < 24; ++i) {
    const dvec3 from = frames[i].position - thing;
    CHECK(glm::dot(from, up) == Approx(1.5).margin(kMargin));
    CHECK(glm::length(from) == Approx(std::hypot(3, 1.5)).margin(kMargin));
    CHECK(glm::distance(frames[i].position, frames[(i + 1) % 24].position) ==
          Approx(2 * 3 * std::sin(std::numbers::pi / 24)).margin(kMargin));
    const Camera camera = camera_at(frames[i], 100, 80);
    CHECK(glm::distance(camera.image_from_cam(camera.cam_from_world(thing)), glm::dvec2(50, 40)) < 1e-3);
    CHECK(frames[i].fov_deg == 50);
    mean += from / 24.0;
  }
  CHECK(glm::distance(mean, 1.5 * up) < kMargin);
  CHECK(glm::distance(frames[0].position, stored[0].center()) < kMargin);
  // Parallel lines of sight meet nowhere, a single camera has one, and cameras may stand where they look.
  CHECK(orbit(std::vector<Camera>(3, stored[0]), 2, 5, 50).size() == 5);
  CHECK(orbit(std::span(stored).first(1), 2, 1, 50).size() == 1);
}

TEST_CASE("a walk goes through the stored cameras in their order, also where several are the same") {
  std::vector<Camera> stored;
  for (std::size_t i = 0; i < 6; ++i) stored.push_back(room_camera(2 * i));
  stored.insert(stored.begin() + 3, stored[2]);
  const std::vector<Vantage> frames = walk(stored, 2, 4001, 70);
  std::size_t from = 0;
  for (const Camera& camera : stored) {
    // The frame nearest to it, no earlier than the one before.
    std::size_t nearest = from;
    for (std::size_t i = from; i < frames.size(); ++i) {
      if (glm::distance(frames[i].position, camera.center()) <
          glm::distance(frames[nearest].position, camera.center())) {
        nearest = i;
      }
    }
    CHECK(glm::distance(frames[nearest].position, camera.center()) < 0.01);
    const glm::dmat3 turned = glm::mat3_cast(frames[nearest].cam_from_world);
    CHECK(glm::dot(glm::transpose(turned)[2], camera.viewing_direction()) > 0.999);
    from = nearest;
  }
  CHECK(glm::distance(frames.back().position, stored.back().center()) < 1e-9);
  CHECK(walk(std::span(stored).first(1), 2, 3, 70).size() == 3);
}

TEST_CASE("Hilbert's curve visits each cell once, and goes from neighbour to neighbour") {
  for (std::uint32_t order = 0; order <= kMostHilbertOrder; ++order) {
    const std::vector<glm::ivec2> cells = hilbert_cells(order);
    const int side = 1 << order;
    std::set<std::pair<int, int>> visited;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      REQUIRE((cells[i].x >= 0 && cells[i].y >= 0 && cells[i].x < side && cells[i].y < side));
      visited.emplace(cells[i].x, cells[i].y);
      if (i == 0) continue;
      const glm::ivec2 step = cells[i] - cells[i - 1];
      REQUIRE(std::abs(step.x) + std::abs(step.y) == 1);
    }
    CHECK(cells.size() == static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    CHECK(visited.size() == cells.size());
  }
  CHECK_THROWS_WITH(hilbert_cells(9), Catch::Contains("order is 9"));
}

TEST_CASE("a Hilbert flight covers the ground at the cameras' height, at an even pace, looking ahead") {
  const auto surface = room_surface();  // 4 x 4 x 3
  std::vector<Camera> stored;
  for (std::size_t i = 0; i < 9; ++i) {
    const dvec3 position(1.0 + 0.2 * static_cast<double>(i), 2, 1.7);
    const double heading = 0.7 * static_cast<double>(i);
    const dvec3 ahead(std::cos(heading), std::sin(heading), -0.2);
    stored.push_back(camera_at({position, look_at(position, position + ahead, {0, 0, 1}), 60}, 64, 48));
  }
  const std::vector<Vantage> frames = hilbert_flight(surface->mesh, stored, 2, 400, 70);
  REQUIRE(frames.size() == 400);
  std::set<std::pair<int, int>> visited;
  const double step = glm::distance(frames[0].position, frames[1].position);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const dvec3& at = frames[i].position;
    CHECK(at.z == Approx(1.7).margin(1e-4));
    REQUIRE((at.x > 0 && at.y > 0 && at.x < 4 && at.y < 4));
    visited.emplace(static_cast<int>(at.x), static_cast<int>(at.y));
    const dvec3 looks = glm::transpose(glm::mat3_cast(frames[i].cam_from_world))[2];
    CHECK(looks.z == Approx(-0.2 / std::hypot(1, 0.2)).margin(1e-4));
    if (i == 0) continue;
    const dvec3 moved = at - frames[i - 1].position;
    CHECK(glm::length(moved) == Approx(step).epsilon(0.05));  // chords of a curve
    CHECK(glm::dot(glm::normalize(dvec3(looks.x, looks.y, 0)), glm::normalize(moved)) > 0.98);
  }
  CHECK(visited.size() == 16);
  CHECK_THROWS_WITH(hilbert_flight(surface->mesh, stored, 0, 9, 70), Catch::Contains("order is 0"));
  CHECK_THROWS_WITH(hilbert_flight({}, stored, 2, 9, 70), Catch::Contains("mesh has no faces"));
  CHECK(hilbert_flight(surface->mesh, stored, 1, 1, 70).size() == 1);
}

TEST_CASE("an open spline goes from its first point to its last, a closed one back to its beginning, both smoothly") {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> any(-1, 1);
  std::vector<dvec3> points;
  for (int i = 0; i < 7; ++i) points.emplace_back(any(random), any(random), any(random));
  const Spline open(points, Spline::Ends::open);
  CHECK(glm::distance(open.at(0), points.front()) < 1e-12);
  CHECK(glm::distance(open.at(open.length()), points.back()) < 1e-12);
  const Spline closed(points, Spline::Ends::closed);
  CHECK(glm::distance(closed.at(0), closed.at(closed.length())) < 1e-12);
  for (const Spline* spline : {&open, &closed}) {
    for (double t = 0.05; t < spline->length() - 0.05; t += 0.05) {
      constexpr double kStep = 1e-5;
      const dvec3 measured = (spline->at(t + kStep) - spline->at(t - kStep)) / (2 * kStep);
      CHECK(glm::distance(spline->derivative(t), measured) < 1e-8);
    }
    const std::vector<double> steps = spline->equal_steps(1000);
    const double first = glm::distance(spline->at(steps[0]), spline->at(steps[1]));
    for (std::size_t i = 1; i < steps.size(); ++i) {
      CHECK(glm::distance(spline->at(steps[i - 1]), spline->at(steps[i])) == Approx(first).epsilon(0.05));
    }
  }
  CHECK(open.equal_steps(5).back() == Approx(open.length()));
  CHECK(closed.equal_steps(5).back() < closed.length() - 0.5);
  CHECK_THROWS_WITH(Spline({{}, {}, {}}, Spline::Ends::closed), "spline: has 3 points, must have at least 4");
}

}  // namespace
}  // namespace lumatlas
