// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/camera/camera.h"

#include <catch2/catch.hpp>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <stdexcept>

namespace lumatlas {
namespace {

Camera turned_camera() {
  Camera camera;
  camera.width = 64;
  camera.height = 48;
  camera.fx = 70;
  camera.fy = 65;
  camera.cx = 30;
  camera.cy = 25;
  camera.cam_from_world_rotation = glm::mat3_cast(glm::normalize(glm::dquat(0.9, 0.1, -0.3, 0.2)));
  camera.cam_from_world_translation = {1, -2, 3};
  return camera;
}

TEST_CASE("a ray through a pixel at a depth projects back to that pixel and depth") {
  const Camera camera = turned_camera();
  const glm::dvec2 pixel(12.5, 40.5);
  const glm::dvec3 cam = camera.cam_from_world(camera.center() + 3.7 * camera.ray(pixel));
  CHECK(cam.z == Approx(3.7));
  CHECK(glm::length(camera.image_from_cam(cam) - pixel) < 1e-10);
}

TEST_CASE("the camera's centre is the origin of its frame and it looks along z") {
  const Camera camera = turned_camera();
  CHECK(glm::length(camera.cam_from_world(camera.center())) < 1e-12);
  const glm::dvec3 ahead = camera.cam_from_world(camera.center() + camera.viewing_direction());
  CHECK(glm::length(ahead - glm::dvec3(0, 0, 1)) < 1e-12);
}

TEST_CASE("a scaled camera sees a point at the same relative place") {
  const Camera camera = turned_camera();
  const Camera half = camera.scaled_to(32, 12);
  const glm::dvec3 cam(0.3, -0.2, 2);
  CHECK(half.image_from_cam(cam).x / 32 == Approx(camera.image_from_cam(cam).x / 64));
  CHECK(half.image_from_cam(cam).y / 12 == Approx(camera.image_from_cam(cam).y / 48));
}

TEST_CASE("a shrunk camera keeps its shape and what it sees, however thin it is, and is never enlarged") {
  const Camera camera = turned_camera();
  const Camera small = camera.shrunk_to(16);
  CHECK(small.width == 16);
  CHECK(small.height == 12);
  const glm::dvec3 cam(0.3, -0.2, 2);
  CHECK(small.image_from_cam(cam).x / 16 == Approx(camera.image_from_cam(cam).x / 64));
  CHECK(camera.scaled_to(48, 64).shrunk_to(16).height == 16);
  const Camera slit = camera.scaled_to(64, 1).shrunk_to(8);
  CHECK(slit.width == 8);
  CHECK(slit.height == 1);
  for (const std::uint32_t pixels : {64u, 65u, 4'000'000'000u}) {
    CHECK(camera.shrunk_to(pixels).width == 64);
    CHECK(camera.shrunk_to(pixels).fx == camera.fx);
  }
}

TEST_CASE("a camera with a bad field is refused by name") {
  CHECK_NOTHROW(check(turned_camera()));
  Camera camera = turned_camera();
  camera.width = 0;
  CHECK_THROWS_WITH(check(camera), Catch::Contains("width") && Catch::Contains("[1, 65536]"));
  camera = turned_camera();
  camera.fy = -1;
  CHECK_THROWS_WITH(check(camera), Catch::Contains("fy"));
  camera = turned_camera();
  camera.cam_from_world_translation.y = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(check(camera), std::invalid_argument);
  camera = turned_camera();
  camera.cam_from_world_rotation *= 2.0;
  CHECK_THROWS_WITH(check(camera), Catch::Contains("orthonormal"));
  camera = turned_camera();
  camera.cam_from_world_rotation[0] *= -1.0;
  CHECK_THROWS_WITH(check(camera), Catch::Contains("determinant"));
}

}  // namespace
}  // namespace lumatlas
