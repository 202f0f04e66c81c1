// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/measures/pose_error.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <vector>

#include "mesh/visibility/visibility.h"
#include "tests/support/scenes/wall_scenes.h"
#include "tools/lab/synth/errors/disturbance.h"

namespace lumatlas {
namespace {

// 64x48 pixels, focal length 64; on a ring around the z axis, all seeing the wall and the panel.
std::vector<Camera> ring_of_cameras(int count) {
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * 3.14159265358979 * i / count;
    const glm::dvec3 center(0.5 * std::cos(angle), 0.4 * std::sin(angle), 0.3 * std::sin(3 * angle));
    Camera camera = oblique_camera(64, 48, 0.1 * std::sin(angle), center);
    cameras.push_back(camera);
  }
  return cameras;
}

RigidMotion small_motion() {
  const glm::dvec3 axis = glm::normalize(glm::dvec3(0.2, -1, 0.4));
  return {glm::mat3_cast(glm::angleAxis(0.03, axis)), {0.05, -0.02, 0.04}};
}

RigidMotion inverse(const RigidMotion& motion) {
  const glm::dmat3 back = glm::transpose(motion.rotation);
  return {back, -(back * motion.translation)};
}

std::vector<PosePair> pairs_of(const std::vector<Camera>& truth, const std::vector<Camera>& measured) {
  const auto visibility = make_ray_visibility(wall_and_panel()->mesh);
  std::vector<PosePair> pairs;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    pairs.push_back({truth[i], measured[i], points_seen(truth[i], *visibility)});
  }
  return pairs;
}

std::vector<Camera> all_before(const std::vector<Camera>& cameras, const RigidMotion& motion) {
  std::vector<Camera> moved;
  for (const Camera& camera : cameras) moved.push_back(before_motion(camera, motion));
  return moved;
}

double error_px(const PosePair& pair, const RigidMotion& motion) {
  return synth::displacement_px(pair.truth, before_motion(pair.measured, motion), pair.points);
}

// Turned in its place by `turn` radians about its own z axis.
Camera rolled(const Camera& camera, double turn) {
  const glm::dmat3 roll = glm::mat3_cast(glm::angleAxis(turn, glm::dvec3(0, 0, 1)));
  Camera result = camera;
  result.cam_from_world_rotation = roll * camera.cam_from_world_rotation;
  result.cam_from_world_translation = roll * camera.cam_from_world_translation;
  return result;
}

}  // namespace

TEST_CASE("a camera sees at each point what it saw where the motion takes it", "[pose error]") {
  const Camera camera = oblique_camera(64, 48, 0.3, {0.1, 0.2, -0.3});
  const RigidMotion motion = small_motion();
  const glm::dvec3 point(0.3, -0.2, 3.5);
  const glm::dvec3 expected = camera.cam_from_world(motion.rotation * point + motion.translation);
  CHECK(glm::distance(before_motion(camera, motion).cam_from_world(point), expected) < 1e-12);
}

TEST_CASE("points seen lie on the surface, one for each pixel of a picture 32 wide", "[pose error]") {
  const auto visibility = make_ray_visibility(wall_and_panel()->mesh);
  const std::vector<glm::dvec3> points = points_seen(forward_camera(64, 48), *visibility);
  REQUIRE(points.size() == 32 * 24);  // the wall fills the picture
  for (const glm::dvec3& point : points) {
    const bool on_panel = std::abs(point.x) < 0.25 && std::abs(point.y) < 0.25 && std::abs(point.z - 2) < 1e-5;
    CHECK((on_panel || std::abs(point.z - 4) < 1e-5));
  }
}

TEST_CASE("a shift across a wall displaces it by focal length times shift over depth", "[pose error]") {
  const Camera truth = forward_camera(64, 48);
  const std::vector<glm::dvec3> wall = {{-1, -1, 4}, {1, -1, 4}, {0, 0.5, 4}};
  const RigidMotion shift{glm::dmat3(1.0), {0.25, 0, 0}};
  CHECK(synth::displacement_px(truth, before_motion(truth, shift), wall) == Approx(64 * 0.25 / 4).epsilon(1e-12));
}

TEST_CASE("cameras that moved together have a common motion that leaves no error", "[pose error]") {
  const std::vector<Camera> truth = ring_of_cameras(5);
  const std::vector<PosePair> pairs = pairs_of(truth, all_before(truth, inverse(small_motion())));
  const RigidMotion found = common_motion(pairs);
  for (const PosePair& pair : pairs) {
    CHECK(error_px(pair, {}) > 0.5);
    CHECK(error_px(pair, found) < 1e-6);
  }
  for (int axis = 0; axis < 3; ++axis) {
    CHECK(found.translation[axis] == Approx(small_motion().translation[axis]).margin(1e-7));
  }
}

TEST_CASE("one lost camera does not drag the common motion of the others along", "[pose error]") {
  const std::vector<Camera> truth = ring_of_cameras(6);
  std::vector<Camera> measured = all_before(truth, inverse(small_motion()));
  measured[2] = rolled(measured[2], 0.8);
  const std::vector<PosePair> pairs = pairs_of(truth, measured);
  const RigidMotion found = common_motion(pairs);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (i != 2) CHECK(error_px(pairs[i], found) < 0.1);
  }
  CHECK(error_px(pairs[2], found) > 5);
}

TEST_CASE("true cameras, and no cameras, have no common motion", "[pose error]") {
  const std::vector<Camera> truth = ring_of_cameras(3);
  const RigidMotion found = common_motion(pairs_of(truth, truth));
  CHECK(glm::length(found.translation) < 1e-12);
  const RigidMotion none = common_motion({});
  CHECK(none.rotation == glm::dmat3(1.0));
  CHECK(none.translation == glm::dvec3(0.0));
}

}  // namespace lumatlas
