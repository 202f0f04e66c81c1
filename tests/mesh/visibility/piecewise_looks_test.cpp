// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/visibility/piecewise_looks.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <random>
#include <stdexcept>
#include <vector>

#include "mesh/visibility/shown_box.h"

namespace lumatlas {
namespace {

Camera camera_in_a_town(double turn, const glm::dvec3& center) {
  Camera camera;
  camera.width = 64;
  camera.height = 48;
  camera.fx = camera.fy = 50;
  camera.cx = 32;
  camera.cy = 24;
  camera.cam_from_world_rotation = glm::mat3_cast(glm::angleAxis(turn, glm::dvec3(0, 1, 0)));
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * center);
  return camera;
}

// Triangles at random places around `middle`.
Mesh cloud(std::uint32_t seed, const glm::vec3& middle) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  Mesh mesh;
  for (std::uint32_t face = 0; face < 60; ++face) {
    const glm::vec3 place = middle + 2.0f * glm::vec3(uniform(random), uniform(random), uniform(random));
    for (int corner = 0; corner < 3; ++corner) {
      mesh.positions.push_back(place + 0.6f * glm::vec3(uniform(random), uniform(random), uniform(random)));
    }
    mesh.faces.emplace_back(3 * face, 3 * face + 1, 3 * face + 2);
  }
  return mesh;
}

std::vector<Mesh> clouds() {
  std::vector<Mesh> meshes;
  std::uint32_t seed = 1;
  for (const float x : {-5.0f, 0.0f, 5.0f}) {
    for (const float z : {-5.0f, 0.0f, 5.0f}) meshes.push_back(cloud(seed++, {x, 0, z}));
  }
  return meshes;
}

Mesh joined_mesh(const std::vector<Mesh>& meshes) {
  Mesh all;
  for (const Mesh& mesh : meshes) {
    const auto first = static_cast<std::uint32_t>(all.positions.size());
    all.positions.insert(all.positions.end(), mesh.positions.begin(), mesh.positions.end());
    for (const glm::uvec3& face : mesh.faces) all.faces.push_back(face + first);
  }
  return all;
}

// Counts how often each piece was loaded.
struct CountedPieces {
  std::vector<MeshPiece> pieces;
  std::vector<int> loads;

  explicit CountedPieces(const std::vector<Mesh>& meshes) : loads(meshes.size(), 0) {
    for (std::size_t i = 0; i < meshes.size(); ++i) {
      pieces.push_back({bounds(meshes[i]), meshes[i].faces.size(), [this, i, mesh = meshes[i]] {
                          ++loads[i];
                          return mesh;
                        }});
    }
  }
  CountedPieces(const CountedPieces&) = delete;
  CountedPieces& operator=(const CountedPieces&) = delete;
};

TEST_CASE("a mesh in pieces looks as it does in one, however many pictures are held") {
  const std::vector<Mesh> meshes = clouds();
  const std::unique_ptr<Visibility> whole = make_ray_visibility(joined_mesh(meshes));
  std::vector<Camera> cameras;
  for (int look = 0; look < 24; ++look) {
    cameras.push_back(camera_in_a_town(0.5 * look, {4.0 * std::sin(0.9 * look), 0.2, 4.0 * std::cos(1.7 * look)}));
  }
  constexpr std::uint64_t kPicture = 64 * 48 * 8;
  for (const std::uint64_t bytes : {std::uint64_t{0}, 5 * kPicture, 100 * kPicture}) {
    CountedPieces counted(meshes);
    std::size_t next = 0, seen = 0;
    look_at_pieces(counted.pieces, cameras, bytes, [&](std::size_t camera, const VisibilityBuffer& found) {
      REQUIRE(camera == next++);
      const VisibilityBuffer expected = whole->trace(cameras[camera]);
      REQUIRE(found.width == expected.width);
      REQUIRE(found.height == expected.height);
      for (std::size_t pixel = 0; pixel < expected.face.size(); ++pixel) {
        REQUIRE(found.face[pixel] == expected.face[pixel]);
        REQUIRE(found.depth[pixel] == expected.depth[pixel]);
        seen += expected.face[pixel] != FaceId::none ? 1 : 0;
      }
    });
    CHECK(next == cameras.size());
    CHECK(seen > 20'000);
    const int rounds = bytes == 0 ? 24 : bytes == 5 * kPicture ? 5 : 1;
    for (const int loads : counted.loads) CHECK(loads <= rounds);
  }
}

TEST_CASE("pieces behind what a camera sees, and beside its image, are not loaded") {
  Mesh wall;
  wall.positions = {{-90, -90, 3}, {90, -90, 3}, {0, 90, 3}};
  wall.faces = {{0, 1, 2}};
  Mesh behind = wall;
  for (glm::vec3& position : behind.positions) position = {0.1f * position.x, 0.1f * position.y, 9};
  CountedPieces counted({wall, behind, cloud(7, {0, 0, -50})});
  const std::vector<Camera> cameras{camera_in_a_town(0, {0, 0, 0})};
  look_at_pieces(counted.pieces, cameras, 0,
                 [](std::size_t, const VisibilityBuffer& seen) { CHECK(seen.face[64 * 24 + 32] == FaceId(0)); });
  CHECK(counted.loads == std::vector<int>{1, 0, 0});
}

TEST_CASE("looks at pieces can be stopped, and refuse a bad camera") {
  CountedPieces counted(clouds());
  std::vector<Camera> cameras{camera_in_a_town(0, {0, 0, 0})};
  const auto use = [](std::size_t, const VisibilityBuffer&) {};
  int checks = 0;
  const CancelCheck stop = [&] {
    if (++checks == 3) throw std::runtime_error("stopped");
  };
  CHECK_THROWS_AS(look_at_pieces(counted.pieces, cameras, 0, use, stop), std::runtime_error);
  cameras.front().fx = -1;
  CHECK_THROWS_AS(look_at_pieces(counted.pieces, cameras, 0, use), std::invalid_argument);
}

TEST_CASE("a box is shown where its corners are, with its depths") {
  const Camera camera = camera_in_a_town(0, {0, 0, 0});
  const ShownBox ahead = shown_box(camera, {{-1, -1, 10}, {1, 1, 20}});
  CHECK(ahead.left == 27);
  CHECK(ahead.right == 37);
  CHECK(ahead.top == 19);
  CHECK(ahead.bottom == 29);
  CHECK(ahead.near == 10);
  CHECK(ahead.far == 20);
  CHECK(shown_box(camera, {{-1, -1, -20}, {1, 1, -10}}).empty());
  CHECK(shown_box(camera, {{40, -1, 10}, {41, 1, 20}}).empty());
  const ShownBox around = shown_box(camera, {{-1, -1, -5}, {1, 1, 20}});
  CHECK((around.left == 0 && around.right == 64 && around.top == 0 && around.bottom == 48));
  CHECK(around.near == 0);
}

}  // namespace
}  // namespace lumatlas
