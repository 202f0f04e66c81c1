// SPDX-License-Identifier: GPL-3.0-or-later
// A board before a wall, whose mesh has only the left half of the board.
#include "tools/meshing/faces_before.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "tests/support/scenes/measured_panels.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

constexpr double kBoardDepth = 2.5;

// Both sides of the board are red; the wall behind is green.
glm::vec3 board_color(const glm::dvec3& point) {
  const auto wave = static_cast<float>(std::sin(17 * point.x) * std::cos(13 * point.y));
  return point.z < 3 ? glm::vec3(180 + 40 * wave, 40, 30) : glm::vec3(40, 150 + 60 * wave, 60);
}

struct BoardScene {
  Mesh truth, given, other;
  FaceRange left, right;
  std::vector<MeasuredView> views;

  // `measured_to`: where the depths say that the board ends, which truly ends at 0.5.
  explicit BoardScene(double measured_to = 0.5) {
    add_panel(-4, 4, -3, 3, 4, truth);
    add_panel(-0.5, 0.5, -0.4, 0.4, kBoardDepth, truth);
    add_panel(-4, 4, -3, 3, 4, other);
    left = add_panel(-0.5, 0, -0.4, 0.4, kBoardDepth, other);
    right = add_panel(0, measured_to, -0.4, 0.4, kBoardDepth, other);
    add_panel(-4, 4, -3, 3, 4, given);
    add_panel(-0.5, 0, -0.4, 0.4, kBoardDepth, given);
    photograph();
  }

  void photograph() {
    const std::unique_ptr<Visibility> measured = make_ray_visibility(other), seen = make_ray_visibility(truth);
    views.clear();
    for (int i = 0; i < 5; ++i) {
      const Camera camera = forward_camera(240, 180, {0.4 * i - 0.8, 0, 0});
      views.push_back(measured_view(camera, measured->trace(camera), seen->trace(camera), board_color));
    }
  }

  [[nodiscard]] FacesBefore before() const {
    return faces_before(given, other, views, [] {});
  }
};

TEST_CASE("the half of a board that a mesh lacks stands before it, and nothing else does") {
  const BoardScene scene;
  const FacesBefore found = scene.before();
  CHECK(found.groups == 1);
  CHECK(share_in(found.faces, scene.right) > 0.85);
  CHECK(share_in(found.faces, {0, scene.left.end}) == 0);
}

TEST_CASE("nothing stands before a mesh that has it all") {
  BoardScene scene;
  scene.given = scene.truth;
  CHECK(scene.before().faces.empty());
}

TEST_CASE("what depths alone show before a mesh is not there") {
  // Matching makes the board wider than it is: the wall's green is beside its end, at the board's depth.
  const BoardScene wide(1.0);
  const FacesBefore found = wide.before();
  std::size_t too_far = 0, true_ones = 0;
  for (const std::uint32_t face : found.faces) {
    const float x = wide.other.positions[wide.other.faces[face].x].x;
    ++(x > 0.55f ? too_far : true_ones);
  }
  CHECK(too_far == 0);
  CHECK(true_ones > 150);  // of 320
}

TEST_CASE("photographs from one direction prove nothing, nor do depths that one other photograph confirms") {
  BoardScene near_together;
  for (MeasuredView& view : near_together.views) view = near_together.views[2];
  CHECK(near_together.before().faces.empty());
  BoardScene weak;
  for (MeasuredView& view : weak.views) {
    for (std::uint32_t& agreeing : view.measured.agreeing) agreeing &= 1U;
  }
  CHECK(weak.before().faces.empty());
}

TEST_CASE("a caller can end the search for what stands before a mesh") {
  const BoardScene scene;
  CHECK_THROWS_WITH(faces_before(scene.given, scene.other, scene.views, [] { throw std::runtime_error("enough"); }),
                    "enough");
}

}  // namespace
}  // namespace lumatlas
