// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/paths/kept_path.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

#include "tools/picture/paths/camera_tours.h"

namespace lumatlas {
namespace {

using glm::dvec3;

constexpr double kHalf = std::numbers::pi / 2;
const dvec3 kUp(0, 0, 1);

// A thing at the origin, photographed from a quarter of a circle around it.
std::vector<Camera> quarter() {
  std::vector<Camera> cameras;
  for (int i = 0; i < 12; ++i) {
    const double angle = kHalf * i / 11;
    const dvec3 position(3 * std::cos(angle), 3 * std::sin(angle), 1);
    cameras.push_back(camera_at({position, look_at(position, dvec3(0), kUp), 60}, 64, 48));
  }
  return cameras;
}

double angle_of(const Vantage& vantage) {
  return std::atan2(vantage.position.y, vantage.position.x);
}

dvec3 ahead(const Vantage& vantage) {
  return glm::transpose(glm::mat3_cast(vantage.cam_from_world))[2];
}

// Only from the quarter, and a little beside it, is something seen.
double seen_from_quarter(const Vantage& vantage) {
  const double angle = angle_of(vantage);
  return angle > -0.3 && angle < kHalf + 0.3 && vantage.position.z < 2 ? 0.8 : 0;
}

TEST_CASE("an orbit past what was photographed comes back to it, smoothly, and says what it covers") {
  const std::vector<Camera> stored = quarter();
  const std::vector<Vantage> circle = orbit(stored, 3, 120, 60);
  const KeptPath kept = keep_to_photographs(circle, stored, kUp, 3, true, seen_from_quarter);
  REQUIRE(kept.vantages.size() == 120);
  CHECK(kept.covered_before == Approx((kHalf + 0.6) / (4 * kHalf)).margin(0.02));
  CHECK(kept.covered == 1);
  std::size_t moved = 0;
  for (std::size_t i = 0; i < 120; ++i) {
    const Vantage& now = kept.vantages[i];
    const Vantage& next = kept.vantages[(i + 1) % 120];
    moved += glm::distance(now.position, circle[i].position) > 1e-9 ? 1 : 0;
    CHECK(glm::distance(now.position, next.position) < 1.5);
    CHECK(glm::dot(glm::transpose(glm::mat3_cast(now.cam_from_world))[0], kUp) ==
          Approx(0).margin(0.002));  // as exact as the orbit's own up
    // Well within the quarter nothing is to be gained.
    const double angle = angle_of(circle[i]);
    if (angle > 0.3 && angle < kHalf - 0.3) CHECK(glm::distance(now.position, circle[i].position) < 1e-9);
  }
  CHECK(moved == kept.moved);
  CHECK(moved > 60);
}

TEST_CASE("an orbit of which an arc was photographed swings to and fro over it, and closes") {
  const std::vector<Camera> stored = quarter();
  const KeptPath kept = kept_orbit(stored, 3, 120, 60, seen_from_quarter);
  CHECK(kept.covered == 1);
  CHECK(kept.covered_before < 0.5);
  CHECK(kept.arc_deg == Approx(glm::degrees(kHalf + 0.6)).margin(8));
  double least = 10, most = -10;
  for (std::size_t i = 0; i < 120; ++i) {
    const double angle = angle_of(kept.vantages[i]);
    least = std::min(least, angle);
    most = std::max(most, angle);
    CHECK(glm::distance(kept.vantages[i].position, kept.vantages[(i + 1) % 120].position) < 0.2);
    CHECK(glm::length(kept.vantages[i].position) == Approx(std::hypot(3, 1)).margin(0.05));
    // The way back is the way there.
    CHECK(angle_of(kept.vantages[(120 - i) % 120]) == Approx(angle).margin(1e-6));
  }
  CHECK(most - least == Approx(glm::radians(kept.arc_deg)).margin(0.03));  // about the thing, not the orbit's axis

  const auto everywhere = [](const Vantage&) { return 0.5; };
  const KeptPath whole = kept_orbit(stored, 3, 40, 60, everywhere);
  CHECK(whole.arc_deg == 360);
  CHECK(whole.moved == 0);
  const std::vector<Vantage> circle = orbit(stored, 3, 40, 60);
  for (std::size_t i = 0; i < 40; ++i) CHECK(whole.vantages[i].position == circle[i].position);
  CHECK_THROWS_WITH(kept_orbit({}, 3, 40, 60, everywhere), "tour: there is no stored view, must be at least one");
}

TEST_CASE("frames that show enough stay where they are, to the bit") {
  const std::vector<Camera> stored = quarter();
  const std::vector<Vantage> circle = orbit(stored, 3, 40, 60);
  const KeptPath kept = keep_to_photographs(circle, stored, kUp, 3, true, [](const Vantage&) { return 0.3; });
  CHECK(kept.moved == 0);
  CHECK(kept.covered == 1);
  CHECK(kept.covered_before == 1);
  for (std::size_t i = 0; i < 40; ++i) CHECK(kept.vantages[i].position == circle[i].position);
}

TEST_CASE("a single frame in the void goes to the camera nearest to it, no further than it must") {
  const std::vector<Camera> stored = quarter();
  const dvec3 high(0, 3, 5);
  const std::vector<Vantage> path(3, Vantage{high, look_at(high, dvec3(0, 3, 6), dvec3(1, 0, 0)), 60});
  const KeptPath kept = keep_to_photographs(path, stored, kUp, 3, false, seen_from_quarter);
  CHECK(kept.covered_before == 0);
  CHECK(kept.covered == 1);
  for (const Vantage& vantage : kept.vantages) {
    CHECK(vantage.position.z < 2);
    CHECK(vantage.position.z > 1.2);
    CHECK(vantage.fov_deg == 60);
    CHECK(std::isfinite(ahead(vantage).x));
  }
}

TEST_CASE("where nothing helps, the path says so, and without cameras there is none") {
  const std::vector<Camera> stored = quarter();
  const std::vector<Vantage> circle = orbit(stored, 3, 16, 60);
  const PhotographedShare only_cameras = [&](const Vantage& vantage) {
    return glm::distance(vantage.position, stored[0].center()) < 0.1 ? 0.9 : 0.2;
  };
  CHECK(keep_to_photographs(circle, std::span(stored).first(1), kUp, 3, true, only_cameras).covered > 0);
  CHECK(keep_to_photographs({}, stored, kUp, 3, true, only_cameras).vantages.empty());
  CHECK_THROWS_WITH(keep_to_photographs(circle, {}, kUp, 3, true, only_cameras),
                    "tour: there is no stored view, must be at least one");
}

}  // namespace
}  // namespace lumatlas
