// SPDX-License-Identifier: GPL-3.0-or-later
// Which of what photographs show past a mesh is taken to be far, on scenes whose depth is known.
#include "tools/pipeline/surface/far_background.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <vector>

#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

using Texture = std::function<double(const glm::dvec3& direction, const glm::dvec3& center)>;

// Five cameras in a row of two units.
std::vector<Camera> row_of_cameras() {
  std::vector<Camera> cameras;
  for (int i = 0; i < 5; ++i) cameras.push_back(forward_camera(160, 120, {0.5 * i - 1, 0, 0}));
  return cameras;
}

SmallPhotograph photograph(const Camera& camera, const Texture& texture) {
  SmallPhotograph result;
  result.camera = camera;
  for (std::uint32_t y = 0; y < camera.height; ++y) {
    for (std::uint32_t x = 0; x < camera.width; ++x) {
      const double level = texture(glm::normalize(camera.ray({x + 0.5, y + 0.5})), camera.center());
      result.color.emplace_back(static_cast<float>(level));
      result.valid.push_back(1);
    }
  }
  return result;
}

double waves(double x, double y) {
  return 128 + 60 * std::sin(23 * x + 1) * std::cos(19 * y) + 30 * std::sin(71 * x + 43 * y);
}

// An infinitely far background, and a wall three units before the cameras.
double far_waves(const glm::dvec3& direction, const glm::dvec3& /*center*/) {
  return waves(direction.x / direction.z, direction.y / direction.z);
}
double near_waves(const glm::dvec3& direction, const glm::dvec3& center) {
  const glm::dvec3 point = center + 3 / direction.z * direction;
  return waves(point.x / 3, point.y / 3);
}

// The mesh is a panel in the lower half of the pictures.
Mesh panel() {
  Mesh mesh;
  mesh.positions = {{-9, 0.2F, 3}, {9, 0.2F, 3}, {-9, 9, 3}, {9, 9, 3}};
  mesh.faces = {{0, 2, 1}, {1, 2, 3}};
  return mesh;
}

// The share of the pixels of all cameras that see the far sphere that is found.
double far_share(const Texture& texture, std::size_t photographs = 5) {
  const std::vector<Camera> cameras = row_of_cameras();
  const Mesh mesh = panel();
  const auto visibility = make_ray_visibility(mesh);
  std::vector<SmallPhotograph> small;
  for (std::size_t i = 0; i < photographs; ++i) small.push_back(photograph(cameras[i], texture));
  const FarSphere far = find_far_sphere(small, cameras, mesh, *visibility);
  if (far.mesh.faces.empty()) return 0;
  CHECK(far.cells.cell_of_face.size() == far.mesh.faces.size());
  const auto far_visibility = make_ray_visibility(far.mesh);
  double sum = 0;
  for (const Camera& camera : cameras) {
    const FrameShare share = frame_share(camera, *visibility, far_visibility.get());
    CHECK(share.surface > 0.35);
    CHECK(share.surface + share.far <= 1);
    CHECK(share.pixels == 160 * 120);
    sum += share.far / static_cast<double>(cameras.size());
  }
  return sum;
}

// The mesh leaves 58 % of the pictures free.
TEST_CASE("what photographs agree to be far becomes the far sphere") {
  CHECK(far_share(far_waves) > 0.5);
}

TEST_CASE("so does a sky without detail, brighter in some photographs than in others") {
  const auto sky = [](const glm::dvec3& direction, const glm::dvec3& center) {
    return 180 + 20 * direction.y + 12 * center.x;
  };
  CHECK(far_share(sky) > 0.5);
}

TEST_CASE("what is near and has no surface is not far") {
  CHECK(far_share(near_waves) < 0.03);
}

TEST_CASE("where near and far meet, each is told") {
  // Near to the left.
  const auto both = [](const glm::dvec3& direction, const glm::dvec3& center) {
    const bool is_near = (center + 3 / direction.z * direction).x < 0;
    return is_near ? near_waves(direction, center) : far_waves(direction, center);
  };
  const double share = far_share(both);
  CHECK(share > 0.05);
  CHECK(share < 0.4);
}

TEST_CASE("what one photograph alone shows is not far, though it borders on what is far") {
  const auto sky = [](const glm::dvec3& direction, const glm::dvec3& /*center*/) { return 180 + 20 * direction.y; };
  std::vector<Camera> cameras = row_of_cameras();
  Camera turned = cameras[2];  // it shares a sixth of its width with the others
  turned.cam_from_world_rotation = glm::dmat3(glm::rotate(glm::dmat4(1), glm::radians(45.0), glm::dvec3(0, 1, 0)));
  cameras.push_back(turned);
  std::vector<SmallPhotograph> small;
  for (const Camera& camera : cameras) small.push_back(photograph(camera, sky));
  const Mesh mesh = panel();
  const auto visibility = make_ray_visibility(mesh);
  const FarSphere far = find_far_sphere(small, cameras, mesh, *visibility);
  REQUIRE(!far.mesh.faces.empty());
  const auto far_visibility = make_ray_visibility(far.mesh);
  CHECK(frame_share(cameras[2], *visibility, far_visibility.get()).far > 0.5);
  CHECK(frame_share(turned, *visibility, far_visibility.get()).surface < 0.5);
  CHECK(frame_share(turned, *visibility, far_visibility.get()).far < 0.2);
}

TEST_CASE("one photograph alone tells nothing, and left-out pixels neither") {
  CHECK(far_share(far_waves, 1) == 0);
  const std::vector<Camera> cameras = row_of_cameras();
  const Mesh mesh = panel();
  std::vector<SmallPhotograph> masked;
  for (const Camera& camera : cameras) {
    masked.push_back(photograph(camera, far_waves));
    masked.back().valid.assign(masked.back().valid.size(), 0);
  }
  CHECK(find_far_sphere(masked, cameras, mesh, *make_ray_visibility(mesh)).mesh.faces.empty());
}

}  // namespace
}  // namespace lumatlas
