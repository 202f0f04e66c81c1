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
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

// Adds a grid of squares of side 0.05 in a plane across the z axis, and returns the numbers of its faces.
struct FaceRange {
  std::size_t first = 0, end = 0;
};
FaceRange add_panel(double left, double right, double top, double bottom, double depth, Mesh& mesh) {
  const FaceRange before{mesh.faces.size(), 0};
  const auto columns = static_cast<std::uint32_t>(std::lround((right - left) / 0.05));
  const auto rows = static_cast<std::uint32_t>(std::lround((bottom - top) / 0.05));
  const auto start = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::uint32_t y = 0; y <= rows; ++y) {
    for (std::uint32_t x = 0; x <= columns; ++x) mesh.positions.emplace_back(left + 0.05 * x, top + 0.05 * y, depth);
  }
  for (std::uint32_t y = 0; y < rows; ++y) {
    for (std::uint32_t x = 0; x < columns; ++x) {
      const std::uint32_t a = start + y * (columns + 1) + x, b = a + columns + 1;
      mesh.faces.emplace_back(a, b, a + 1);
      mesh.faces.emplace_back(a + 1, b, b + 1);
    }
  }
  return {before.first, mesh.faces.size()};
}

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
    MeasuredView view;
    view.measured.camera = camera;
    for (std::size_t pixel = 0; pixel < seen.face.size(); ++pixel) {
      const std::size_t x = pixel % camera.width, y = pixel / camera.width;
      const glm::dvec3 ray = camera.ray({static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5});
      const glm::dvec3 point = camera.center() + double{seen.depth[pixel]} * ray;
      const bool is_known = seen.face[pixel] != FaceId::none;
      float depth = is_known ? measured.depth[pixel] : 0;
      if (is_known && is_plain(point)) depth *= static_cast<float>(misread);
      view.measured.depth.push_back(depth);
      view.measured.deviation.push_back(0.002F * depth);
      view.measured.agreeing.push_back(depth > 0 ? 7 : 0);
      view.color.push_back(is_known ? room_color(point) : glm::vec3(0));
      view.valid.push_back(1);
    }
    return view;
  }

  [[nodiscard]] ContradictedFaces contradicted() const {
    return contradicted_faces(given, views, [] {});
  }
};

// The share of some faces that are in an ascending list.
double share_in(const std::vector<std::uint32_t>& faces, const FaceRange& of) {
  const auto first = std::lower_bound(faces.begin(), faces.end(), of.first);
  const auto last = std::lower_bound(faces.begin(), faces.end(), of.end);
  return static_cast<double>(last - first) / static_cast<double>(of.end - of.first);
}

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
