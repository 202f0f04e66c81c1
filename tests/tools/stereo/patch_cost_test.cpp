// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/stereo/patch_cost.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>

#include "tests/support/scenes/relief_scenes.h"

namespace lumatlas {
namespace {

TEST_CASE("a pixel goes where the other camera sees its point") {
  const Camera from = camera_on_arc(0), to = camera_on_arc(12);
  const PixelTransfer transfer = pixel_transfer(from, to);
  const glm::dvec2 pixel(100.5, 60.5);
  for (const double depth : {2.0, 4.0, 100.0}) {
    const glm::dvec3 point = from.center() + depth * from.ray(pixel);
    const glm::vec3 at = transfer.homogeneous(pixel, static_cast<float>(1 / depth));
    const glm::dvec2 expected = to.image_from_cam(to.cam_from_world(point));
    CHECK(at.x / at.z == Approx(expected.x).margin(1e-3));
    CHECK(at.y / at.z == Approx(expected.y).margin(1e-3));
  }
}

// A plane z = 4 before the arc's middle, seen from straight ahead, with the relief's colours.
struct FlatWall {
  Camera left = camera_on_arc(0), right = camera_on_arc(10);
  LumaImage left_image = image(left), right_image = image(right);

  static LumaImage image(const Camera& camera) {
    Photograph photograph{camera.width, camera.height, {}, {}};
    for (std::uint32_t y = 0; y < camera.height; ++y) {
      for (std::uint32_t x = 0; x < camera.width; ++x) {
        const glm::dvec3 ray = camera.ray({x + 0.5, y + 0.5}), center = camera.center();
        const glm::dvec3 color = relief_color(center + (4 - center.z) / ray.z * ray);
        for (int c = 0; c < 3; ++c) photograph.rgb.push_back(static_cast<std::uint8_t>(std::lround(1000 * color[c])));
      }
    }
    return luma_pyramid(photograph, camera, camera.width, camera.width).front();
  }
};

TEST_CASE("the true plane costs next to nothing, a wrong depth or slope more") {
  const FlatWall wall;
  const glm::ivec2 pixel(120, 90);
  const ReferencePatch patch = reference_patch(wall.left_image, pixel);
  const PixelTransfer transfer = pixel_transfer(wall.left, wall.right);
  const auto cost = [&](const SlantedPlane& plane) {
    return patch_cost(patch, pixel, plane, transfer, wall.right_image);
  };
  const float truth = cost({0.25F, 0, 0});
  CHECK(truth < 0.1F);
  CHECK(cost({0.27F, 0, 0}) > truth + 0.02F);
  CHECK(cost({0.23F, 0, 0}) > truth + 0.02F);
  CHECK(cost({0.25F, 0.01F, 0}) > truth + 0.02F);
}

TEST_CASE("what the other photograph does not show costs the most") {
  const FlatWall wall;
  const glm::ivec2 pixel(2, 90);
  const ReferencePatch patch = reference_patch(wall.left_image, pixel);
  const PixelTransfer transfer = pixel_transfer(wall.left, wall.right);
  CHECK(patch_cost(patch, pixel, {5, 0, 0}, transfer, wall.right_image) == kLargestPatchCost);
  // A plane that is so steep that it passes behind the camera within the patch.
  CHECK(patch_cost(patch, pixel, {0.25F, 10, 0}, transfer, wall.right_image) == kLargestPatchCost);
}

TEST_CASE("a patch at the border of the picture and of the mask weighs what is inside alone") {
  FlatWall wall;
  const ReferencePatch corner = reference_patch(wall.left_image, {0, 0});
  float sum = 0;
  std::size_t outside = 0;
  for (std::size_t i = 0; i < kPatchSamples; ++i) {
    sum += corner.weight[i];
    outside += corner.weight[i] == 0 ? 1 : 0;
  }
  CHECK(sum == Approx(1));
  CHECK(outside == 24);
  wall.left_image.valid.assign(wall.left_image.quads.size(), 0);
  CHECK(reference_patch(wall.left_image, {120, 90}).variance == 0);
}

}  // namespace
}  // namespace lumatlas
