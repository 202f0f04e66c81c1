// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/stereo/stereo_neighbors.h"

#include <catch2/catch.hpp>

#include "tests/support/scenes/relief_scenes.h"

namespace lumatlas {
namespace {

// Cameras at these degrees of an arc round the wall's middle, four units from it.
std::vector<Camera> arc(const std::vector<double>& degrees) {
  std::vector<Camera> cameras;
  for (const double at : degrees) cameras.push_back(camera_on_arc(at));
  return cameras;
}

std::vector<std::vector<std::uint32_t>> seen_by_all(std::size_t points, std::uint32_t cameras) {
  std::vector<std::uint32_t> all;
  for (std::uint32_t camera = 0; camera < cameras; ++camera) all.push_back(camera);
  return std::vector<std::vector<std::uint32_t>>(points, all);
}

TEST_CASE("the best neighbour sees the same points from some degrees aside") {
  const Relief relief;
  const std::vector<Camera> cameras = arc({0, 0.5, 8, 50});
  const std::vector<glm::dvec3> points = relief.points(cameras[0], 10, 8);
  const auto plans = plan_stereo(cameras, points, seen_by_all(points.size(), 4), 2);
  REQUIRE(plans.size() == 4);
  REQUIRE_FALSE(plans[0].neighbors.empty());
  CHECK(plans[0].neighbors[0] == 2);
  CHECK(plans[0].neighbors.size() == 2);
}

TEST_CASE("depths of the points are in the range, which is wider, and seeds have them") {
  const Relief relief;
  const std::vector<Camera> cameras = arc({0, 8});
  const std::vector<glm::dvec3> points = relief.points(cameras[0], 10, 8);
  const StereoPlan plan = plan_stereo(cameras, points, seen_by_all(points.size(), 2), 4)[0];
  CHECK(plan.range.least < 1 / 4.5F);
  CHECK(plan.range.most > 1 / 3.5F);
  CHECK(plan.range.most < 1);
  REQUIRE(plan.seeds.size() == points.size());
  const glm::dvec3 cam = cameras[0].cam_from_world(points[5]);
  CHECK(plan.seeds[5].w == Approx(1 / cam.z));
  CHECK(plan.seeds[5].place.x == Approx(cameras[0].image_from_cam(cam).x / cameras[0].width));
}

TEST_CASE("without points, or without word of who saw them, neighbours are told from the cameras") {
  const std::vector<Camera> cameras = arc({0, 8, 16, 90});
  const StereoPlan plan = plan_stereo(cameras, {}, {}, 2)[0];
  REQUIRE(plan.neighbors.size() == 2);
  CHECK(plan.neighbors[0] < 3);
  CHECK(plan.neighbors[1] < 3);
  CHECK(plan.range.least < 0.2F);
  CHECK(plan.range.most > 0.3F);
  const Relief relief;
  const std::vector<glm::dvec3> points = relief.points(cameras[0], 10, 8);
  const std::vector<std::vector<std::uint32_t>> unknown(points.size());
  const StereoPlan of_points = plan_stereo(cameras, points, unknown, 1)[0];
  REQUIRE(of_points.neighbors.size() == 1);
  CHECK(of_points.neighbors[0] == 1);
  CHECK(of_points.seeds.empty());
}

TEST_CASE("a camera that shares nothing with others, and cameras at one place, have no neighbours") {
  std::vector<Camera> cameras = arc({0, 8});
  cameras.push_back(relief_camera({0, 0, 0}, {0, 0, -4}));  // looks away
  const Relief relief;
  const std::vector<glm::dvec3> points = relief.points(cameras[0], 10, 8);
  const auto plans = plan_stereo(cameras, points, seen_by_all(points.size(), 2), 4);
  CHECK(plans[0].neighbors == std::vector<std::size_t>{1});
  CHECK(plans[2].neighbors.empty());
  CHECK(plan_stereo(arc({0, 0}), {}, {}, 4)[0].neighbors.empty());
  CHECK(plan_stereo(arc({0}), {}, {}, 4)[0].neighbors.empty());
}

}  // namespace
}  // namespace lumatlas
