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

namespace lumatlas {
namespace {

// Looks at the origin.
Camera camera_at(const glm::dvec3& center) {
  Camera camera;
  camera.width = 160;
  camera.height = 120;
  camera.fx = camera.fy = 150;
  camera.cx = 80;
  camera.cy = 60;
  const glm::dvec3 forward = -glm::normalize(center);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0.11, 0.23, 1)));
  camera.cam_from_world_rotation = glm::transpose(glm::dmat3(right, glm::cross(forward, right), forward));
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * center);
  return camera;
}

// Exact depths of the unit ball.
DepthImage ball_from(const glm::dvec3& center) {
  DepthImage image{camera_at(center), {}};
  for (std::uint32_t y = 0; y < image.camera.height; ++y) {
    for (std::uint32_t x = 0; x < image.camera.width; ++x) {
      const glm::dvec3 ray = image.camera.ray({x + 0.5, y + 0.5});
      const double a = glm::dot(ray, ray);
      const double half = glm::dot(ray, center);
      const double root = half * half - a * (glm::dot(center, center) - 1);
      image.depth.push_back(root < 0 ? 0.0F : static_cast<float>((-half - std::sqrt(root)) / a));
    }
  }
  return image;
}

std::vector<DepthImage> ball_from_all_sides() {
  std::vector<DepthImage> images;
  for (const double x : {-2.5, 2.5}) {
    for (const double y : {-2.5, 2.5}) {
      for (const double z : {-2.5, 2.5}) images.push_back(ball_from({x, y, z}));
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-3.5, 3.5}) {
      glm::dvec3 center(0.0);
      center[axis] = side;
      images.push_back(ball_from(center));
    }
  }
  return images;
}

// Edges of one face alone.
std::size_t open_edges(const TriangleSoup& soup) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  for (const glm::uvec3& face : soup.faces) {
    for (int corner = 0; corner < 3; ++corner) {
      const auto [low, high] = std::minmax({face[corner], face[(corner + 1) % 3]});
      ++uses[{low, high}];
    }
  }
  return static_cast<std::size_t>(
      std::count_if(uses.begin(), uses.end(), [](const auto& edge) { return edge.second == 1; }));
}

FusionOptions ball_options() {
  FusionOptions options;
  options.voxel = 0.05;
  options.truncation = 0.15;
  options.least_weight = 0.01;
  return options;
}

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

// The coordinates, so that they can be looked up.
std::set<std::tuple<double, double, double>> vertices_of(const TriangleSoup& soup) {
  std::set<std::tuple<double, double, double>> vertices;
  for (const glm::dvec3& p : soup.positions) vertices.emplace(p.x, p.y, p.z);
  return vertices;
}

TEST_CASE("a growing surface of all images is as near to the true one as the surface of a fusion at once") {
  GrowingFusion fusion(ball_options());
  CHECK(fusion.surface().faces.empty());
  for (const DepthImage& image : ball_from_all_sides()) {
    REQUIRE(fusion.add(image));
    CHECK_FALSE(fusion.surface().faces.empty());
  }
  const TriangleSoup soup = fusion.surface(GrowingFusion::Show::everything);
  CHECK(open_edges(soup) == 0);
  const Mesh mesh = repair(soup, glm::dvec3(0)).mesh;
  CHECK(is_manifold_and_oriented(mesh));
  CHECK(area_of(mesh) == Approx(4 * std::numbers::pi).epsilon(0.03));
  for (const glm::vec3& p : mesh.positions) CHECK(std::abs(glm::length(p) - 1) < 0.03);  // 0.6 voxels
}

TEST_CASE("a growing surface keeps its vertices to the bit where images add little") {
  GrowingFusion fusion(ball_options());
  for (const DepthImage& image : ball_from_all_sides()) REQUIRE(fusion.add(image));
  const TriangleSoup before = fusion.surface();
  const auto were_there = vertices_of(before);
  REQUIRE(fusion.add(ball_from({3, 0, 0})));
  CHECK((vertices_of(fusion.surface()) == were_there));  // it adds less than was there
  for (int image = 0; image < 12; ++image) REQUIRE(fusion.add(ball_from({3, 0.1 * image, 0})));
  std::size_t moved = 0;
  for (const glm::dvec3& p : fusion.surface().positions) {
    const bool was_there = were_there.contains({p.x, p.y, p.z});
    if (p.x < 0) CHECK(was_there);  // the images see nothing of it
    if (!was_there) ++moved;
  }
  CHECK(moved > 0);
  CHECK(moved < before.positions.size() / 2);
}

TEST_CASE("a growing surface refuses an image that takes too many blocks, and stays as it was") {
  FusionOptions options = ball_options();
  GrowingFusion enough(options);
  REQUIRE(enough.add(ball_from({3, 0, 0})));
  options.max_blocks = enough.blocks();
  GrowingFusion fusion(options);
  REQUIRE(fusion.add(ball_from({3, 0, 0})));
  const auto vertices = vertices_of(fusion.surface());
  CHECK_FALSE(fusion.add(ball_from({-3, 0, 0})));
  CHECK(fusion.blocks() == options.max_blocks);
  CHECK((vertices_of(fusion.surface(GrowingFusion::Show::everything)) == vertices));
  options.voxel = 0;
  CHECK_THROWS_AS(GrowingFusion(options), std::invalid_argument);
  CHECK_THROWS_AS(fusion.add(DepthImage{camera_at({3, 0, 0}), {1, 2}}), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
