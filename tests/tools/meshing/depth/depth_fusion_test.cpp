// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/depth/depth_fusion.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "mesh/repair/repair.h"
#include "tests/support/scenes/surfaces.h"
#include "tests/tools/meshing/depth/ball_depths.h"
#include "tools/meshing/depth/fusion_blocks.h"

namespace lumatlas {
namespace {

TEST_CASE("depth images of a ball from all sides give a closed ball that faces outwards, to a part of a voxel") {
  const TriangleSoup soup = fused(ball_from_all_sides(), ball_options());
  CHECK(open_edges(soup) == 0);
  const Mesh mesh = repair(soup, glm::dvec3(0)).mesh;
  CHECK(is_manifold_and_oriented(mesh));
  // Repair parts the sheets that met in one voxel: rare, and of no width.
  CHECK(boundary_edges(mesh) < mesh.faces.size() / 200);
  const double pi = std::numbers::pi;
  CHECK(volume_of(mesh) == Approx(4.0 / 3 * pi).epsilon(0.02));
  CHECK(area_of(mesh) == Approx(4 * pi).epsilon(0.03));
  for (const glm::vec3& p : mesh.positions) CHECK(std::abs(glm::length(p) - 1) < 0.03);  // 0.6 voxels
}

TEST_CASE("more than a million blocks near a depth image are each there once, in order") {
  DepthImage image{camera_at({3, 0, 1}), {}};
  image.depth.assign(std::size_t{image.camera.width} * image.camera.height, 1.0F);
  FusionOptions options;
  options.voxel = 1e-4;
  options.truncation = 0.1;
  const std::vector<glm::ivec3> blocks = blocks_near(image, options);
  CHECK(blocks.size() > 2'000'000);
  CHECK(std::is_sorted(blocks.begin(), blocks.end(), by_block_key));
  CHECK(std::adjacent_find(blocks.begin(), blocks.end()) == blocks.end());
}

TEST_CASE("what no depth image shows is open, not closed") {
  const std::vector<DepthImage> one{ball_from({3, 0, 0})};
  const Mesh mesh = repair(fused(one, ball_options()), glm::dvec3(0)).mesh;
  CHECK(is_manifold_and_oriented(mesh));
  CHECK(boundary_edges(mesh) > 50);
  for (const glm::vec3& p : mesh.positions) CHECK(p.x > 0.2F);  // the horizon is at x = 1/3
  const double cap = 2 * std::numbers::pi * (1 - 1.0 / 3);
  CHECK(area_of(mesh) > 0.4 * cap);  // where it is seen aslant, no voxel behind it is within the truncation
  CHECK(area_of(mesh) < 1.1 * cap);
}

// The ground z = 0, seen from so far above it and from 3 units away.
DepthImage ground_from(double height) {
  DepthImage image{camera_at({3, 0, height}), {}};
  const Camera& camera = image.camera;
  const auto depth_at = [&](double x, double y) { return -height / camera.ray({x, y}).z; };
  for (std::uint32_t row = 0; row < camera.height; ++row) {
    for (std::uint32_t column = 0; column < camera.width; ++column) {
      const double x = column + 0.5, y = row + 0.5, depth = depth_at(x, y);
      const glm::dvec3 ray = camera.ray({x, y});
      const bool is_near = depth > 0 && depth < 5;
      image.depth.push_back(is_near ? static_cast<float>(depth) : 0.0F);
      image.cosine.push_back(is_near ? static_cast<float>(-ray.z / glm::length(ray)) : 0.0F);
      image.slope.emplace_back(depth_at(x + 0.5, y) - depth_at(x - 0.5, y),
                               depth_at(x, y + 0.5) - depth_at(x, y - 0.5));
    }
  }
  return image;
}

// Returns the area of the faces over the square of side 1 about the origin.
double area_in_middle(const TriangleSoup& soup) {
  double area = 0;
  for (const glm::uvec3& face : soup.faces) {
    const glm::dvec3 a = soup.positions[face[0]], b = soup.positions[face[1]], c = soup.positions[face[2]];
    const glm::dvec3 middle = (a + b + c) / 3.0;
    if (std::abs(middle.x) < 0.5 && std::abs(middle.y) < 0.5) area += glm::length(glm::cross(b - a, c - a)) / 2;
  }
  return area;
}

TEST_CASE("what is only seen aslant has no holes where the slant is known") {
  const DepthImage slanted = ground_from(0.5);  // 80 degrees from its normal
  DepthImage plain = slanted;
  plain.cosine.clear();
  plain.slope.clear();
  FusionOptions options = ball_options();
  options.least_weight = 0.001;
  const TriangleSoup whole = fused({&slanted, 1}, options);
  CHECK(area_in_middle(whole) == Approx(1).epsilon(0.06));                  // of faces, which end beside the square
  for (const glm::dvec3& p : whole.positions) CHECK(std::abs(p.z) < 0.01);  // a fifth of a voxel
  CHECK(area_in_middle(fused({&plain, 1}, options)) < 0.5);
}

TEST_CASE("smaller voxels give a surface nearer to the true one, of as many more faces as there are edges") {
  FusionOptions options = ball_options();
  std::size_t coarse = 0;
  double error_before = 1;
  for (const double voxel : {0.12, 0.06, 0.03}) {
    options.voxel = voxel;
    options.truncation = 3 * voxel;
    const TriangleSoup soup = fused(ball_from_all_sides(), options);
    double squares = 0;
    for (const glm::dvec3& p : soup.positions) squares += std::pow(glm::length(p) - 1, 2);
    const double error = std::sqrt(squares / static_cast<double>(soup.positions.size()));
    CHECK(error < 0.7 * error_before);
    error_before = error;
    if (coarse > 0)
      CHECK(static_cast<double>(soup.faces.size()) == Approx(4.0 * static_cast<double>(coarse)).epsilon(0.05));
    coarse = soup.faces.size();
    // A unit of a ball's surface crosses 3/2 edges of a unit grid on average, each with two faces.
    CHECK(static_cast<double>(soup.faces.size()) * voxel * voxel ==
          Approx(2 * 1.5 * 4 * std::numbers::pi).epsilon(0.05));
  }
}

TEST_CASE("the noise of depth images is averaged out, each image as trusted as it is near") {
  // A wall at x = 0, which one camera sees 0.02 too near and one 0.02 too far, from twice as far.
  const auto wall = [](double distance, double error) {
    DepthImage image{camera_at({distance, 0, 0}), {}};
    image.depth.assign(std::size_t{160} * 120, static_cast<float>(distance + error));
    return image;
  };
  FusionOptions options = ball_options();
  options.voxel = 0.02;
  const std::vector<DepthImage> images{wall(1, -0.02), wall(2, 0.02)};
  const TriangleSoup soup = fused(images, options);
  REQUIRE(soup.positions.size() > 100);
  for (const glm::dvec3& p : soup.positions) {
    if (std::abs(p.y) > 0.2 || std::abs(p.z) > 0.2) continue;  // where both see it, nearly straight ahead
    CHECK(p.x == Approx((0.02 * 1 - 0.02 * 0.25) / 1.25).margin(0.001));
  }
}

TEST_CASE("a voxel says nothing before enough images have seen it") {
  FusionOptions options = ball_options();
  options.least_weight = 1.5 / 4;  // of images from a distance of about 2
  const std::vector<DepthImage> one{ball_from({3, 0, 0})};
  CHECK(fused(one, options).faces.empty());
  const std::vector<DepthImage> two{one[0], one[0]};
  CHECK(fused(two, options).faces.size() > 100);
}

TEST_CASE("fusion is the same for any number of threads") {
  const auto run = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return fused(ball_from_all_sides(), ball_options());
  };
  const TriangleSoup one = run(1);
  const TriangleSoup four = run(4);
  CHECK((one.positions == four.positions));
  CHECK((one.faces == four.faces));
}

TEST_CASE("fusion makes its voxels larger rather than take more blocks than it may") {
  FusionOptions options = ball_options();
  const std::size_t free = fused(ball_from_all_sides(), options).faces.size();
  options.max_blocks = 100;  // the ball's surface takes some 300 at this voxel size
  const TriangleSoup bounded = fused(ball_from_all_sides(), options);
  CHECK(bounded.faces.size() > 100);
  CHECK(bounded.faces.size() < free / 2);
}

TEST_CASE("fusion refuses bad options and images by name, and makes nothing of nothing") {
  FusionOptions options;
  CHECK(fused({}, options).faces.empty());
  options.voxel = 0;
  CHECK_THROWS_WITH(fused({}, options), "fusion: voxel is 0, must be finite and above 0");
  options = {};
  options.truncation = 0.01;
  CHECK_THROWS_WITH(fused({}, options), "fusion: truncation is 0.01, must be finite and at least a voxel");
  options = {};
  options.least_weight = 0;
  CHECK_THROWS_WITH(fused({}, options), "fusion: least_weight is 0, must be finite and above 0");
  options = {};
  options.max_blocks = 0;
  CHECK_THROWS_WITH(fused({}, options), "fusion: max_blocks is 0, must be at least 1");
  std::vector<DepthImage> images{ball_from({3, 0, 0})};
  images[0].depth.pop_back();
  CHECK_THROWS_WITH(fused(images, {}), "fusion: image 0 has 19199 depths, must have 19200");
  images[0].depth.push_back(1e9F);
  CHECK_THROWS_WITH(fused(images, {}), Catch::Contains("too far from the origin"));
}

}  // namespace
}  // namespace lumatlas
