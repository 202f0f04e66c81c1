// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/visibility/piecewise_visibility.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <random>
#include <thread>

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

std::vector<MeshPiece> pieces_of(const std::vector<Mesh>& meshes) {
  std::vector<MeshPiece> pieces;
  for (const Mesh& mesh : meshes) pieces.push_back({bounds(mesh), mesh.faces.size(), [&mesh] { return mesh; }});
  return pieces;
}

TEST_CASE("a mesh in pieces looks as it does in one, however many pieces are kept") {
  const std::vector<Mesh> meshes = clouds();
  const std::unique_ptr<Visibility> whole = make_ray_visibility(joined_mesh(meshes));
  for (const std::size_t most_faces : {std::size_t{0}, std::size_t{130}, std::size_t{100'000}}) {
    const PiecewiseVisibility pieces(pieces_of(meshes), most_faces);
    std::size_t seen = 0;
    for (int look = 0; look < 24; ++look) {
      const Camera camera = camera_in_a_town(0.5 * look, {4.0 * std::sin(0.9 * look), 0.2, 4.0 * std::cos(1.7 * look)});
      const VisibilityBuffer expected = whole->trace(camera), found = pieces.trace(camera);
      REQUIRE(found.width == expected.width);
      REQUIRE(found.height == expected.height);
      for (std::size_t pixel = 0; pixel < expected.face.size(); ++pixel) {
        REQUIRE(found.face[pixel] == expected.face[pixel]);
        REQUIRE(found.depth[pixel] == expected.depth[pixel]);
        seen += expected.face[pixel] != FaceId::none ? 1 : 0;
      }
    }
    CHECK(seen > 20'000);
    if (most_faces > 1000) CHECK(pieces.loads() <= meshes.size());  // each once
    if (most_faces == 0) CHECK(pieces.loads() > 3 * meshes.size());
  }
}

TEST_CASE("pieces behind what a camera sees, and beside its image, are not loaded") {
  Mesh wall;
  wall.positions = {{-90, -90, 3}, {90, -90, 3}, {0, 90, 3}};
  wall.faces = {{0, 1, 2}};
  Mesh behind = wall;
  for (glm::vec3& position : behind.positions) position = {0.1f * position.x, 0.1f * position.y, 9};
  const std::vector<Mesh> meshes{behind, cloud(7, {0, 0, -50}), wall};
  const PiecewiseVisibility pieces(pieces_of(meshes), 1000);
  const VisibilityBuffer seen = pieces.trace(camera_in_a_town(0, {0, 0, 0}));
  CHECK(seen.face[64 * 24 + 32] == FaceId(61));
  CHECK(pieces.loads() == 1);
}

TEST_CASE("several threads look at pieces at once") {
  const std::vector<Mesh> meshes = clouds();
  const PiecewiseVisibility pieces(pieces_of(meshes), 130);
  const std::unique_ptr<Visibility> whole = make_ray_visibility(joined_mesh(meshes));
  std::atomic<int> wrong = 0;
  {
    std::vector<std::jthread> threads;
    for (int thread = 0; thread < 4; ++thread) {
      threads.emplace_back([&, thread] {
        for (int look = 0; look < 12; ++look) {
          const Camera camera = camera_in_a_town(0.7 * look + thread, {thread - 2.0, 0, 1});
          if (pieces.trace(camera).face != whole->trace(camera).face) ++wrong;
        }
      });
    }
  }
  CHECK(wrong == 0);
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
