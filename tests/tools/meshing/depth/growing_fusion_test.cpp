// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/depth/growing_fusion.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <numbers>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

#include "mesh/repair/repair.h"
#include "tests/support/scenes/surfaces.h"
#include "tests/tools/meshing/depth/ball_depths.h"
#include "tools/meshing/cut/small_pieces.h"

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

// Shows images that come and go at random, and compares each surface with that of a volume made anew of the same
// images.
class ChangingBall {
 public:
  explicit ChangingBall(std::uint32_t seed)
      : random_(seed), images_(ball_from_all_sides()), is_in_(images_.size(), 0) {}

  void change() {
    const std::size_t image = random_() % images_.size();
    if (is_in_[image] != 0) {
      growing.remove(images_[image]);
    } else {
      REQUIRE(growing.add(images_[image]));
    }
    is_in_[image] ^= 1U;
  }
  [[nodiscard]] TriangleSoup made_whole() const {
    GrowingFusion whole(ball_options());
    for (std::size_t image = 0; image < images_.size(); ++image) {
      if (is_in_[image] != 0) REQUIRE(whole.add(images_[image]));
    }
    return whole.surface();
  }

  GrowingFusion growing{ball_options()};

 private:
  std::mt19937 random_;
  std::vector<DepthImage> images_;
  std::vector<std::uint8_t> is_in_;
};

// Checks that positions and faces are those of the soup before that they are said to have been, each once.
void check_previous(const TriangleSoup& before, const GrownSoup& now) {
  REQUIRE(now.previous_position.size() == now.soup.positions.size());
  REQUIRE(now.previous_face.size() == now.soup.faces.size());
  for (std::size_t i = 0; i < now.soup.positions.size(); ++i) {
    const VertexId previous = now.previous_position[i];
    if (previous != VertexId::none) REQUIRE(before.positions.at(previous) == now.soup.positions[i]);
  }
  std::uint32_t next = 0;
  for (std::size_t face = 0; face < now.soup.faces.size(); ++face) {
    const FaceId previous = now.previous_face[face];
    if (previous == FaceId::none) continue;
    REQUIRE(previous >= next);
    next = previous + 1;
    for (int corner = 0; corner < 3; ++corner) {
      REQUIRE(now.previous_position[now.soup.faces[face][corner]] == before.faces.at(previous)[corner]);
    }
  }
}

TEST_CASE("a surface of images that come and go is to the byte that of a volume made anew, and says what stayed") {
  const auto seed = static_cast<std::uint32_t>(GENERATE(range(0, 6)));
  const std::size_t fewest_faces = GENERATE(0U, 60U, 400U);
  CAPTURE(seed, fewest_faces);
  ChangingBall ball(seed);
  TriangleSoup before;
  std::size_t faces = 0, kept_faces = 0;
  for (int version = 0; version < 12; ++version) {
    ball.change();
    GrownSoup grown = ball.growing.grown_surface(GrowingFusion::Show::everything, fewest_faces);
    TriangleSoup whole = ball.made_whole();
    (void)remove_small_pieces(whole, fewest_faces);
    REQUIRE(is_same(grown.soup, whole));
    check_previous(before, grown);
    faces += whole.faces.size();
    kept_faces += static_cast<std::size_t>(std::count_if(grown.previous_face.begin(), grown.previous_face.end(),
                                                         [](FaceId face) { return face != FaceId::none; }));
    before = std::move(grown.soup);
  }
  CHECK(kept_faces > 0);
  CHECK(kept_faces < faces);
}

TEST_CASE("a surface that nothing has changed since says that all of it was there") {
  ChangingBall ball(1);
  ball.change();
  const TriangleSoup before = ball.growing.grown_surface(GrowingFusion::Show::everything, 60).soup;
  const GrownSoup again = ball.growing.grown_surface(GrowingFusion::Show::everything, 60);
  CHECK(is_same(again.soup, before));
  for (VertexId position{0}; position < before.positions.size(); ++position) {
    REQUIRE(again.previous_position[position] == position);
  }
  for (FaceId face{0}; face < before.faces.size(); ++face) REQUIRE(again.previous_face[face] == face);
  // Other pieces are left out: faces that come back are new.
  const GrownSoup whole = ball.growing.grown_surface(GrowingFusion::Show::everything, 0);
  check_previous(again.soup, whole);
}

}  // namespace
}  // namespace lumatlas
