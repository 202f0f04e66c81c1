// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/stereo/scene_stereo.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "mesh/base/errors.h"
#include "tests/support/scenes/relief_scenes.h"
#include "tests/support/temporary_folder.h"
#include "tools/stereo/stereo_points.h"

namespace lumatlas {
namespace {

struct Interruption : std::exception {};

// Four photographs of a wall on disk, from an arc, with some of its points.
struct ReliefScene {
  TemporaryFolder folder;
  std::vector<SceneView> views;
  ScenePoints points;
  StereoOptions options{120, 3};

  ReliefScene() {
    const Relief relief;
    for (int i = 0; i < 4; ++i) {
      const Camera camera = camera_on_arc(6.0 * i);
      const std::string name = std::to_string(i) + ".png";
      write_image(folder / name, relief.photograph(camera));
      const CameraModel lens{
          LensModel::kPinhole, camera.width, camera.height, {camera.fx, camera.fy, camera.cx, camera.cy}};
      views.push_back({name, folder / name, lens, Orientation::as_stored, camera});
    }
    points.positions = relief.points(views[0].camera, 10, 8);
    points.views.assign(points.positions.size(), {0, 1, 2, 3});
  }

  [[nodiscard]] SceneStereo stereo(const std::string& work) const {
    return SceneStereo(views, points, options, folder / work);
  }
};

std::vector<std::string> files_of(const std::filesystem::path& folder) {
  std::vector<std::string> bytes;
  for (int i = 0; i < 4; ++i) bytes.push_back(bytes_of(folder / (std::to_string(i) + ".planes")));
  return bytes;
}

TEST_CASE("work that was stopped goes on where it was, and ends alike") {
  const ReliefScene scene;
  SceneStereo whole = scene.stereo("whole");
  std::size_t steps = 0;
  whole.match([&](std::size_t done) { steps += done; });
  CHECK(steps == whole.steps());

  for (const std::size_t stop : {1U, 3U, 6U}) {
    std::size_t until = stop;
    SceneStereo stopped = scene.stereo("stopped");
    CHECK_THROWS_AS(stopped.match([&](std::size_t) {
      if (--until == 0) throw Interruption();
    }),
                    Interruption);
  }
  const auto first = std::filesystem::last_write_time(scene.folder / "stopped/0.matched");
  SceneStereo resumed = scene.stereo("stopped");
  resumed.match([](std::size_t) {});
  CHECK(std::filesystem::last_write_time(scene.folder / "stopped/0.matched") == first);
  CHECK(files_of(scene.folder / "stopped") == files_of(scene.folder / "whole"));
}

TEST_CASE("planes of a photograph that has changed are found again") {
  ReliefScene scene;
  SceneStereo before = scene.stereo("work");
  before.match([](std::size_t) {});
  const std::vector<std::string> old = files_of(scene.folder / "work");
  scene.views[3].camera.cam_from_world_translation.x += 0.05;
  SceneStereo after = scene.stereo("work");
  after.match([](std::size_t) {});
  const std::vector<std::string> moved = files_of(scene.folder / "work");
  CHECK(moved[3] != old[3]);
  // A lens that undistorts otherwise, to the same pinhole camera.
  scene.views[3].lens.model = LensModel::kOpenCv;
  scene.views[3].lens.parameters[4] = -0.05;
  SceneStereo undistorted = scene.stereo("work");
  undistorted.match([](std::size_t) {});
  CHECK(files_of(scene.folder / "work")[3] != moved[3]);
}

TEST_CASE("points lie on the wall, are seen by several, and no two photographs give the same") {
  const ReliefScene scene;
  SceneStereo stereo = scene.stereo("work");
  stereo.match([](std::size_t) {});
  std::size_t photographs = 0;
  const StereoPoints points = stereo_points(stereo, 2, [&](std::size_t done) { photographs += done; });
  CHECK(photographs == 4);
  REQUIRE(points.positions.size() > 2000);
  CHECK(points.positions.size() < 2 * 60 * 45);
  std::size_t near = 0;
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    CHECK(points.views[i].size() >= 2);
    CHECK(points.deviations[i] > 0);
    const glm::dvec3& at = points.positions[i];
    const double wall = 4 + 0.4 * std::sin(1.7 * at.x + 0.4) * std::cos(1.9 * at.y);
    near += std::abs(at.z - wall) < 0.1 ? 1 : 0;
  }
  CHECK(static_cast<double>(near) > 0.9 * static_cast<double>(points.positions.size()));
}

TEST_CASE("a photograph without a neighbour has no depth, and the others are matched") {
  ReliefScene scene;
  SceneView away = scene.views[0];
  away.camera = relief_camera({0, 0, 0}, {0, 0, -4});
  scene.views.push_back(away);
  SceneStereo stereo = scene.stereo("work");
  stereo.match([](std::size_t) {});
  const StereoDepth depth = stereo.depth(4);
  CHECK(std::none_of(depth.depth.begin(), depth.depth.end(), [](float z) { return z > 0; }));
}

TEST_CASE("options out of range and a photograph that is not there are refused by name") {
  ReliefScene scene;
  scene.options.longest_px = 10;
  CHECK_THROWS_WITH(scene.stereo("work"), "longest_px: 10, must be in [64, 8192]");
  scene.options = {120, 0};
  CHECK_THROWS_WITH(scene.stereo("work"), "neighbors: 0, must be in [1, 16]");
  scene.options = {120, 3};
  std::filesystem::remove(scene.views[2].image);
  SceneStereo stereo = scene.stereo("work");
  CHECK_THROWS_AS(stereo.match([](std::size_t) {}), InputError);
}

TEST_CASE("what the work left is removed, and nothing else") {
  const ReliefScene scene;
  SceneStereo stereo = scene.stereo("work");
  stereo.match([](std::size_t) {});
  std::filesystem::copy(scene.folder / "0.png", scene.folder / "work/mine.png");
  remove_stereo_work(scene.folder / "work");
  CHECK(std::distance(std::filesystem::directory_iterator(scene.folder / "work"), {}) == 1);
  std::filesystem::remove(scene.folder / "work/mine.png");
  remove_stereo_work(scene.folder / "work");
  CHECK_FALSE(std::filesystem::exists(scene.folder / "work"));
  remove_stereo_work(scene.folder / "nowhere");
  const std::filesystem::path file = scene.folder.with_file("file", "mine");
  remove_stereo_work(file);
  CHECK(std::filesystem::exists(file));
  std::filesystem::create_directory(scene.folder / "other");
  (void)scene.folder.with_file("other/notes.planes", "mine");
  remove_stereo_work(scene.folder / "other");
  CHECK(std::filesystem::exists(scene.folder / "other/notes.planes"));
}

TEST_CASE("points of some views are numbered by these") {
  ScenePoints points;
  points.positions.resize(2);
  points.views = {{0, 2, 5}, {1, 3}};
  const std::vector<std::size_t> ranks{2, 3, 5};
  const ScenePoints some = points_of_views(points, ranks);
  CHECK(some.views[0] == std::vector<std::uint32_t>{0, 2});
  CHECK(some.views[1] == std::vector<std::uint32_t>{1});
}

}  // namespace
}  // namespace lumatlas
