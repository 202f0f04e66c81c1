// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/camera/shutter_motion.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <stdexcept>

namespace lumatlas {
namespace {

Camera camera_of(std::uint32_t width, std::uint32_t height) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 500;
  camera.cx = width / 2.0;
  camera.cy = height / 2.0;
  return camera;
}

TEST_CASE("lines are read along the shorter side, and the middle of the picture stays where it is") {
  const Camera lying = camera_of(640, 480), upright = camera_of(480, 640);
  CHECK(readout_time(lying, {10, 0}) == -0.5);
  CHECK(readout_time(lying, {10, 480}) == 0.5);
  CHECK(readout_time(upright, {0, 10}) == -0.5);
  CHECK(readout_time(upright, {480, 10}) == 0.5);
  const ShutterMotion motion{{0.01, -0.02, 0.03}, {0.02, 0.01, -0.04}};
  for (const Camera& camera : {lying, upright}) {
    const glm::dvec2 middle(camera.cx, camera.cy);
    CHECK(glm::distance(when_read(motion, camera, middle), middle) < 1e-9);
  }
}

TEST_CASE("a turn of the camera shears the picture, a step towards it stretches it") {
  const Camera camera = camera_of(640, 480);
  // Turning by 0.01 about the vertical axis moves what is in the middle by 5 pixels from the first line to the last.
  const ShutterMotion turn{{0, 0.01, 0}, {0, 0, 0}};
  CHECK(when_read(turn, camera, glm::dvec2(320, 480)).x == Approx(322.5).margin(0.01));
  CHECK(when_read(turn, camera, glm::dvec2(320, 0)).x == Approx(317.5).margin(0.01));
  CHECK(when_read(turn, camera, glm::dvec2(320, 480)).y == Approx(480).margin(0.01));
  // A step does the same, the more the nearer the point.
  const ShutterMotion step{{0, 0, 0}, {0.02, 0, 0}};
  CHECK(when_read(step, camera, glm::dvec2(320, 480)).x == Approx(325).margin(0.01));
  const glm::dvec3 far = 2.0 * glm::dvec3(0, 240.0 / 500, 1);
  CHECK(camera.image_from_cam(when_read(step, camera, far)).x == Approx(322.5).margin(0.01));
  CHECK(edge_move_px(step, camera) == Approx(5).margin(0.01));
  CHECK(edge_move_px({}, camera) == 0);
}

TEST_CASE("the line that shows a point is the one that is read when the point is there") {
  const Camera camera = camera_of(640, 480);
  const ShutterMotion motion{{0.02, 0.01, -0.01}, {0.03, -0.02, 0.02}};
  for (const glm::dvec3 at : {glm::dvec3(0.3, 0.4, 1), glm::dvec3(-0.9, -0.8, 2), glm::dvec3(0.1, -0.4, 1.2)}) {
    const glm::dvec3 moved = when_read(motion, camera, at);
    const double time = readout_time(camera, camera.image_from_cam(moved));
    const glm::dvec3 exact = at + time * (glm::cross(motion.turn, at) + motion.shift);
    CHECK(glm::distance(camera.image_from_cam(exact), camera.image_from_cam(moved)) < 0.005);
  }
}

TEST_CASE("motions that are no numbers are refused, and points behind the camera stay where they are") {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    CHECK_THROWS_AS(check(ShutterMotion{{0, bad, 0}, {0, 0, 0}}), std::invalid_argument);
    CHECK_THROWS_AS(check(ShutterMotion{{0, 0, 0}, {0, 0, bad}}), std::invalid_argument);
  }
  const Camera camera = camera_of(640, 480);
  const ShutterMotion back{{0, 0, 0}, {0, 0, -9}};
  CHECK(when_read(back, camera, glm::dvec2(100, 470)) == glm::dvec2(100, 470));
}

}  // namespace
}  // namespace lumatlas
