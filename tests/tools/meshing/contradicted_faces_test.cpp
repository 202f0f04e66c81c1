// SPDX-License-Identifier: GPL-3.0-or-later
// A wall with a doorway, whose mesh has a lid over the doorway and a scrap in the air. The photographs also show a pole
// that is too thin for their depths, and a part of the wall without texture.
#include "tools/meshing/contradicted_faces.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "mesh/visibility/visibility.h"
#include "tests/support/scenes/measured_panels.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

constexpr double kDoorX = 0.4, kDoorY = 0.5, kWallDepth = 4;

// The wall around the doorway, and the wall of the room behind it.
void add_walls(Mesh& mesh) {
  add_panel(-4, -kDoorX, -3, 3, kWallDepth, mesh);
  add_panel(kDoorX, 4, -3, 3, kWallDepth, mesh);
  add_panel(-kDoorX, kDoorX, -3, -kDoorY, kWallDepth, mesh);
  add_panel(-kDoorX, kDoorX, kDoorY, 3, kWallDepth, mesh);
  add_panel(-3, 3, -2, 2, 6, mesh);
}
FaceRange add_pole(Mesh& mesh) {
  return add_panel(1.2, 1.25, 0, 1, 3.2, mesh);
}

bool is_plain(const glm::dvec3& point) {
  return point.z < 4.5 && point.x < -1.6;
}

glm::vec3 room_color(const glm::dvec3& point) {
  if (point.z < 3.5) return {30, 20, 20};  // the pole
  if (is_plain(point)) return {200, 200, 200};
  const double wave =
      std::sin(17 * point.x + 3 * point.z) * std::cos(13 * point.y) + std::sin(31 * point.x + 23 * point.y);
  return glm::vec3(static_cast<float>(130 + 45 * wave), static_cast<float>(130 - 30 * wave), 120);
}

struct DoorwayScene {
  Mesh truth, given;
  FaceRange pole, lid, scrap;
  std::vector<MeasuredView> views;

  // `misread`: what the depths say of the part without texture, as a multiple of the truth; 0: nothing.
  explicit DoorwayScene(double misread) {
    add_walls(truth);
    const std::unique_ptr<Visibility> measured = make_ray_visibility(truth);
    add_pole(truth);
    const std::unique_ptr<Visibility> seen = make_ray_visibility(truth);
    for (int i = 0; i < 5; ++i) {
      const Camera camera = forward_camera(240, 180, {0.5 * i - 1, 0, 0});
      views.push_back(view_of(camera, measured->trace(camera), seen->trace(camera), misread));
    }
    add_walls(given);
    pole = add_pole(given);
    lid = add_panel(-kDoorX, kDoorX, -kDoorY, kDoorY, kWallDepth, given);
    scrap = add_panel(0.7, 1.0, -0.8, -0.5, 2.8, given);
  }

  static MeasuredView view_of(const Camera& camera, const VisibilityBuffer& measured, const VisibilityBuffer& seen,
                              double misread) {
    MeasuredView view = measured_view(camera, measured, seen, room_color);
    for (std::size_t pixel = 0; pixel < seen.face.size(); ++pixel) {
      if (seen.face[pixel] == FaceId::none || !is_plain(view.point_at(pixel, seen.depth[pixel]))) continue;
      view.measured.depth[pixel] *= static_cast<float>(misread);
      view.measured.deviation[pixel] *= static_cast<float>(misread);
      if (misread == 0) view.measured.agreeing[pixel] = 0;
    }
    return view;
  }

  [[nodiscard]] ContradictedFaces contradicted() const {
    return contradicted_faces(given, views, [] {});
  }
};

TEST_CASE("a lid over a doorway and a scrap in the air are contradicted, a pole and a plain wall are not") {
  for (const double misread : {0.0, 1.5}) {
    const DoorwayScene scene(misread);
    const ContradictedFaces found = scene.contradicted();
    CHECK(found.groups == 2);
    CHECK(share_in(found.faces, scene.lid) > 0.9);
    CHECK(share_in(found.faces, scene.scrap) > 0.9);
    CHECK(share_in(found.faces, scene.pole) == 0);
    CHECK(share_in(found.faces, {0, scene.pole.first}) == 0);
    CHECK(found.pixels > 0.03);
    CHECK(found.pixels < kMostContradicted);
  }
}

TEST_CASE("a true mesh is contradicted nowhere") {
  DoorwayScene scene(0);
  scene.given = scene.truth;
  const ContradictedFaces found = scene.contradicted();
  CHECK(found.faces.empty());
  CHECK(found.groups == 0);
  CHECK(found.pixels == 0);
}

TEST_CASE("photographs from one direction contradict nothing, nor do depths that one other photograph confirms") {
  DoorwayScene near_together(0);
  for (MeasuredView& view : near_together.views) view = near_together.views[2];
  CHECK(near_together.contradicted().faces.empty());
  DoorwayScene weak(0);
  for (MeasuredView& view : weak.views) {
    for (std::uint32_t& agreeing : view.measured.agreeing) agreeing &= 1U;
  }
  CHECK(weak.contradicted().faces.empty());
}

TEST_CASE("a lid that the photographs do show stays, whatever their depths say") {
  DoorwayScene scene(0);
  const std::unique_ptr<Visibility> seen = make_ray_visibility(scene.given);
  for (MeasuredView& view : scene.views) {
    const StereoDepth& measured = view.measured;
    MeasuredView closed =
        DoorwayScene::view_of(measured.camera, seen->trace(measured.camera), seen->trace(measured.camera), 0);
    view.color = closed.color;
  }
  CHECK(share_in(scene.contradicted().faces, scene.lid) == 0);
}

}  // namespace
}  // namespace lumatlas
