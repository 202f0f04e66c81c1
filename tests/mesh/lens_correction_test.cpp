// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/camera/lens_correction.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <string>

#include "tests/support/refusal.h"

namespace lumatlas {
namespace {

// 400x200 pixels, one unit of the plane z = 1 is 100 pixels.
Camera wide_camera() {
  Camera camera;
  camera.width = 400;
  camera.height = 200;
  camera.fx = camera.fy = 100;
  camera.cx = 200;
  camera.cy = 100;
  return camera;
}

void check_at(const LensCorrection& correction, const glm::dvec2& image, const glm::dvec2& expected) {
  const glm::dvec2 found = uncorrected(correction, wide_camera(), image);
  CAPTURE(found.x, found.y);
  CHECK(glm::distance(found, expected) < 1e-9);
}

TEST_CASE("each term of a correction moves a point as its formula says") {
  // (300, 150) is (1, 0.5) at unit distance: r^2 = 1.25, r^4 = 1.5625.
  const glm::dvec2 at(300, 150);
  check_at({}, at, at);
  check_at({1.1, {0, 0}, 0, 0, 0, 0}, at, {310, 155});
  check_at({1, {0.01, -0.02}, 0, 0, 0, 0}, at, {304, 142});
  check_at({1, {0, 0}, 0.1, 0, 0, 0}, at, {312.5, 156.25});
  check_at({1, {0, 0}, 0, 0.1, 0, 0}, at, {315.625, 157.8125});
  check_at({1, {0, 0}, 0, 0, 0.01, 0}, at, {301, 151.75});
  check_at({1, {0, 0}, 0, 0, 0, 0.01}, at, {303.25, 151});
  check_at({1.1, {0.01, 0}, 0.1, 0, 0, 0}, at, {200 + 1.1 * 112.5 + 4, 100 + 1.1 * 56.25});
}

TEST_CASE("the corner that moves most counts") {
  CHECK(corner_move_px({}, wide_camera()) == 0);
  CHECK(corner_move_px({1.1, {0, 0}, 0, 0, 0, 0}, wide_camera()) == Approx(0.1 * std::hypot(200, 100)));
  Camera askew = wide_camera();
  askew.cx = 150;  // the right corners are 250 pixels away
  CHECK(corner_move_px({1.1, {0, 0}, 0, 0, 0, 0}, askew) == Approx(0.1 * std::hypot(250, 100)));
}

TEST_CASE("corrections combine to first order") {
  const LensCorrection a{1.01, {0.002, 0.001}, 0.01, 0.002, 0.001, 0}, b{0.98, {0, 0.003}, -0.02, 0, 0, 0.001};
  const Camera camera = wide_camera();
  for (const glm::dvec2 image : {glm::dvec2(220, 90), glm::dvec2(300, 150), glm::dvec2(120, 60)}) {
    const glm::dvec2 one_by_one = uncorrected(a, camera, uncorrected(b, camera, image));
    CHECK(glm::distance(uncorrected(combined(a, b), camera, image), one_by_one) < 0.25);
    CHECK(glm::distance(image, one_by_one) > 0.5);
  }
  CHECK(combined(a, {}) == a);
}

TEST_CASE("cameras share a lens if size, focal lengths and principal point are the same, whatever their poses") {
  Camera other = wide_camera();
  other.cam_from_world_translation = {1, 2, 3};
  CHECK(share_a_lens(wide_camera(), other));
  other.cx += 1e-9;
  CHECK(share_a_lens(wide_camera(), other));
  for (const auto field : {&Camera::fx, &Camera::fy, &Camera::cx, &Camera::cy}) {
    other = wide_camera();
    other.*field += 0.01;
    CHECK_FALSE(share_a_lens(wide_camera(), other));
  }
  other = wide_camera();
  other.height = 201;
  CHECK_FALSE(share_a_lens(wide_camera(), other));
}

TEST_CASE("a correction that is none is refused by name") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  CHECK(refusal<LensCorrection>([](LensCorrection&) {}) == "accepted");
  CHECK(refusal<LensCorrection>([](LensCorrection& c) { c.focal = 0; }) ==
        "lens correction: focal is 0, must be finite and positive");
  CHECK(refusal<LensCorrection>([](LensCorrection& c) { c.principal.y = kNan; }) ==
        "lens correction: principal.y is nan, must be finite");
  CHECK(refusal<LensCorrection>([](LensCorrection& c) { c.k1 = kNan; }) ==
        "lens correction: k1 is nan, must be finite");
  CHECK(refusal<LensCorrection>([](LensCorrection& c) { c.p2 = -kNan; }).find("lens correction: p2 is") == 0);
}

}  // namespace
}  // namespace lumatlas
