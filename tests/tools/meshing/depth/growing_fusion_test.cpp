// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/depth/growing_fusion.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "mesh/repair/repair.h"
#include "tests/support/scenes/surfaces.h"
#include "tests/tools/meshing/depth/ball_depths.h"

namespace lumatlas {
namespace {

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

bool is_same(const TriangleSoup& a, const TriangleSoup& b) {
  return a.positions == b.positions && a.faces == b.faces;
}

TEST_CASE("images that are taken out again leave the volume as it was, to the bit, in any order") {
  const std::vector<DepthImage> images = ball_from_all_sides();
  GrowingFusion fusion(ball_options());
  for (const DepthImage& image : images) REQUIRE(fusion.add(image));
  const TriangleSoup surface = fusion.surface(GrowingFusion::Show::everything);
  const std::size_t blocks = fusion.blocks();
  // A loop closure moves all images, one after the other, and the next one moves them back.
  const auto moved = [](DepthImage image) {
    image.camera.cam_from_world_translation += glm::dvec3(0.3, -0.2, 0.1);
    return image;
  };
  for (const DepthImage& image : images) {
    fusion.remove(image);
    REQUIRE(fusion.add(moved(image)));
  }
  CHECK_FALSE(is_same(fusion.surface(), surface));
  const std::vector<DepthImage> backwards(images.rbegin(), images.rend());
  for (const DepthImage& image : backwards) {
    fusion.remove(moved(image));
    REQUIRE(fusion.add(image));
  }
  CHECK(fusion.blocks() == blocks);
  CHECK(is_same(fusion.surface(), surface));
  CHECK(is_same(fusion.surface(GrowingFusion::Show::everything), surface));
  GrowingFusion other_order(ball_options());
  for (const DepthImage& image : backwards) REQUIRE(other_order.add(image));
  CHECK(is_same(other_order.surface(), surface));
  for (const DepthImage& image : images) fusion.remove(image);
  CHECK(fusion.blocks() == 0);
  CHECK(fusion.surface().faces.empty());
}

TEST_CASE("a surface that an image alone showed goes with it, and the rest stays") {
  GrowingFusion fusion(ball_options());
  REQUIRE(fusion.add(ball_from({3, 0, 0})));
  const auto alone = vertices_of(fusion.surface());
  REQUIRE(fusion.add(ball_from({-3, 0, 0})));
  CHECK(fusion.surface().positions.size() > 3 * alone.size() / 2);
  fusion.remove(ball_from({-3, 0, 0}));
  CHECK((vertices_of(fusion.surface()) == alone));
}

}  // namespace
}  // namespace lumatlas
