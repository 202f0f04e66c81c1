// SPDX-License-Identifier: GPL-3.0-or-later
// A build removes a lid over a doorway and a scrap in the air, and keeps the wall and a thin pole.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "atlas/images/srgb.h"
#include "mesh/readers/mesh_file.h"
#include "tests/support/scenes/relief_scenes.h"
#include "tests/support/scenes/wall_scenes.h"
#include "tests/support/temporary_folder.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/surface/completed_surface.h"
#include "tools/scene/forms/colmap/colmap_writer.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

constexpr double kGrid = 0.05, kDoorX = 0.35, kDoorY = 0.4, kFront = 4, kRoom = 5.5, kPole = 3, kScrap = 2.5;

void add_grid(double left, double right, double top, double bottom, double depth, Mesh& mesh) {
  const auto columns = static_cast<std::uint32_t>(std::lround((right - left) / kGrid));
  const auto rows = static_cast<std::uint32_t>(std::lround((bottom - top) / kGrid));
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::uint32_t y = 0; y <= rows; ++y) {
    for (std::uint32_t x = 0; x <= columns; ++x) mesh.positions.emplace_back(left + kGrid * x, top + kGrid * y, depth);
  }
  for (std::uint32_t y = 0; y < rows; ++y) {
    for (std::uint32_t x = 0; x < columns; ++x) {
      const std::uint32_t a = first + y * (columns + 1) + x, b = a + columns + 1;
      mesh.faces.emplace_back(a, b, a + 1);
      mesh.faces.emplace_back(a + 1, b, b + 1);
    }
  }
}

// The wall up to `right`, the room behind its doorway, and the pole before it.
Mesh true_doorway(double right) {
  Mesh mesh;
  add_grid(-4, -kDoorX, -2.5, 2.5, kFront, mesh);
  add_grid(kDoorX, right, -2.5, 2.5, kFront, mesh);
  add_grid(-kDoorX, kDoorX, -2.5, -kDoorY, kFront, mesh);
  add_grid(-kDoorX, kDoorX, kDoorY, 2.5, kFront, mesh);
  add_grid(-2, 2, -2, 2, kRoom, mesh);
  add_grid(0.8, 0.85, -0.3, 0.8, kPole, mesh);
  return mesh;
}
Mesh doorway_with_lid(double right) {
  Mesh mesh = true_doorway(right);
  add_grid(-kDoorX, kDoorX, -kDoorY, kDoorY, kFront, mesh);
  add_grid(-0.8, -0.5, -0.7, -0.4, kScrap, mesh);
  return mesh;
}

std::vector<Camera> doorway_cameras() {
  std::vector<Camera> cameras;
  for (int i = 0; i < 5; ++i) cameras.push_back(forward_camera(240, 180, {0.4 * i - 0.8, 0, 0}));
  return cameras;
}

glm::dvec3 doorway_light(const glm::dvec3& point) {
  return point.z < kPole + 0.1 ? glm::dvec3(0.02) : 2.0 * relief_color(1.7 * point);
}

Photograph doorway_photograph(const Camera& camera, const Visibility& truth) {
  const VisibilityBuffer visible = truth.trace(camera);
  Photograph photograph{camera.width, camera.height, {}, {}};
  for (std::size_t pixel = 0; pixel < visible.depth.size(); ++pixel) {
    const std::size_t x = pixel % camera.width, y = pixel / camera.width;
    const glm::dvec2 image(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
    glm::dvec3 light(0);
    if (visible.face[pixel] != FaceId::none) {
      light = doorway_light(camera.center() + double{visible.depth[pixel]} * camera.ray(image));
    }
    for (int channel = 0; channel < 3; ++channel) photograph.rgb.push_back(srgb8_from_linear(light[channel]));
  }
  return photograph;
}

// The points that a grid of the middle camera's pixels shows, with the views that see each.
std::vector<TrackedPoint> tracked_points(const std::vector<Camera>& cameras, const Visibility& truth) {
  std::vector<VisibilityBuffer> seen;
  for (const Camera& camera : cameras) seen.push_back(truth.trace(camera));
  const Camera& middle = cameras[cameras.size() / 2];
  std::vector<TrackedPoint> points;
  for (std::uint32_t y = 4; y < middle.height; y += 6) {
    for (std::uint32_t x = 4; x < middle.width; x += 6) {
      const float depth = seen[cameras.size() / 2].depth[std::size_t{y} * middle.width + x];
      TrackedPoint point{middle.center() + double{depth} * middle.ray({x + 0.5, y + 0.5}), {200, 100, 50}, {}};
      for (std::uint32_t view = 0; view < cameras.size(); ++view) {
        const glm::dvec3 cam = cameras[view].cam_from_world(point.position);
        const glm::dvec2 at = cameras[view].image_from_cam(cam);
        if (!(at.x >= 0 && at.y >= 0 && at.x < middle.width && at.y < middle.height)) continue;
        const std::size_t pixel = static_cast<std::size_t>(at.y) * middle.width + static_cast<std::size_t>(at.x);
        if (std::abs(double{seen[view].depth[pixel]} - cam.z) < 0.05) point.track.push_back({view, {1, 1}});
      }
      points.push_back(point);
    }
  }
  return points;
}

struct DoorwayBuild {
  TemporaryFolder folder;
  BuildOptions options;

  // The mesh's wall ends at `right`; `points`: structure from motion has left points.
  explicit DoorwayBuild(double right, bool points) {
    fs::create_directories(folder / "images");
    fs::create_directories(folder / "sparse");
    const std::unique_ptr<Visibility> truth = make_ray_visibility(true_doorway(4));
    const std::vector<Camera> cameras = doorway_cameras();
    std::vector<WrittenView> written;
    for (const Camera& camera : cameras) {
      const std::string name = std::to_string(written.size()) + ".png";
      write_image(folder / "images" / name, doorway_photograph(camera, *truth));
      written.push_back({name, camera});
    }
    write_colmap_model(folder / "sparse", written,
                       points ? tracked_points(cameras, *truth) : std::vector<TrackedPoint>());
    const Mesh mesh = doorway_with_lid(right);
    std::ofstream file(folder / "mesh.ply", std::ios::binary);
    write_ply(file, {{mesh.positions.begin(), mesh.positions.end()}, {}, mesh.faces});
    options.texture_px.reset();
    options.refine = RefineMode::none;
    options.measure_deviation = false;
    options.completion.surface = true;
  }

  [[nodiscard]] BuildResult build() const { return build_model(folder.path(), options); }
};

// The share of a panel's vertices that a surface still has.
double share_left(const BuildResult& result, const glm::dvec3& least, const glm::dvec3& most) {
  const Surface& surface = *result.snapshot.surface;
  const Mesh whole = doorway_with_lid(4);
  const auto count = [&](const Mesh& mesh, const glm::dvec3& offset) {
    std::vector<glm::dvec3> inside;
    for (const glm::vec3& position : mesh.positions) {
      const glm::dvec3 at = glm::dvec3(position) + offset;
      if (glm::all(glm::greaterThan(at, least)) && glm::all(glm::lessThan(at, most))) inside.push_back(at);
    }
    return static_cast<double>(inside.size());
  };
  return count(near_surface(surface).mesh, surface.offset) / count(whole, glm::dvec3(0));
}
double lid_left(const BuildResult& result) {
  return share_left(result, {-kDoorX + 0.01, -kDoorY + 0.01, kFront - 0.01},
                    {kDoorX - 0.01, kDoorY - 0.01, kFront + 0.01});
}
double scrap_left(const BuildResult& result) {
  return share_left(result, {-1, -1, kScrap - 0.01}, {0, 0, kScrap + 0.01});
}
double pole_left(const BuildResult& result) {
  return share_left(result, {0.7, -1, kPole - 0.01}, {0.9, 1, kPole + 0.01});
}

TEST_CASE("a build that completes a mesh removes a lid and a scrap, and keeps a thin pole") {
  const BuildResult result = DoorwayBuild(1, false).build();
  CHECK(result.added_faces > 0);
  CHECK(result.removed.groups == 2);
  CHECK(result.removed.faces > 250);
  CHECK(result.removed.pixels > 0.03);
  CHECK(lid_left(result) < 0.2);  // its rim is not told from the wall
  CHECK(scrap_left(result) < 0.1);
  CHECK(pole_left(result) >= 1);
}

TEST_CASE("points that lie behind a whole mesh make a build look for what photographs see through") {
  const DoorwayBuild scene(4, true);
  const MeshInput mesh = load_mesh(scene.folder.path(), std::nullopt, 0);
  const SceneViews views = read_scene_views(scene.folder.path(), mesh.offset);
  const CompletionPlan plan = plan_completion(views, {0, 1, 2, 3, 4}, mesh.mesh, mesh.offset);
  CHECK(plan.through >= 3);
  CHECK(plan.to_match == plan.through);
  const BuildResult result = scene.build();
  CHECK(lid_left(result) < 0.2);  // its rim is not told from the wall
  CHECK(pole_left(result) >= 1);
}

TEST_CASE("a mesh that is to stay as it was given keeps what photographs see through") {
  DoorwayBuild scene(4, true);
  scene.options.completion.surface = false;
  const BuildResult result = scene.build();
  CHECK(result.removed.faces == 0);
  CHECK(lid_left(result) >= 1);
}

}  // namespace
}  // namespace lumatlas
