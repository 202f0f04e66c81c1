// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh of photographs of a wall whose surface is known.
#include "tools/meshing/photograph_mesh.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "mesh/base/errors.h"
#include "mesh/readers/mesh_file.h"
#include "tests/support/scenes/relief_scenes.h"
#include "tests/support/temporary_folder.h"
#include "tools/scene/forms/colmap/colmap_writer.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

const StageProgress kNoProgress = [](const std::string&, std::size_t) { return [](std::size_t) {}; };

// A COLMAP workspace of a wall, seen from an arc, with a few of its points; `middle` in the scene's coordinates.
struct WallScene {
  TemporaryFolder folder;
  glm::dvec3 middle;
  SceneMeshOptions options;

  explicit WallScene(const glm::dvec3& at = glm::dvec3(0), bool with_points = true) : middle(at) {
    fs::create_directories(folder / "images");
    fs::create_directories(folder / "sparse");
    const Relief relief;
    std::vector<WrittenView> written;
    for (int i = 0; i < 5; ++i) {
      Camera camera = camera_on_arc(6.0 * i - 12);
      const std::string name = std::to_string(i) + ".png";
      write_image(folder / "images" / name, relief.photograph(camera));
      camera.cam_from_world_translation -= camera.cam_from_world_rotation * middle;
      written.push_back({name, camera});
    }
    std::vector<TrackedPoint> tracked;
    if (with_points) {
      for (const glm::dvec3& point : relief.points(camera_on_arc(0), 8, 6)) {
        TrackedPoint seen{point + middle, {200, 100, 50}, {}};
        for (std::uint32_t view = 0; view < 5; ++view) seen.track.push_back({view, {1, 1}});
        tracked.push_back(seen);
      }
    }
    write_colmap_model(folder / "sparse", written, tracked);
    options.stereo.longest_px = 160;
    options.stereo_folder = folder / "work";
  }

  [[nodiscard]] SceneMesh mesh() const { return mesh_from_scene(folder.path(), options, kNoProgress); }

  // The share of the vertices within a tenth of a unit, which is five pixels, of the wall.
  [[nodiscard]] double share_on_wall(const SceneMesh& made) const {
    std::size_t near = 0;
    for (const glm::dvec3& position : made.surface.positions) {
      const glm::dvec3 at = position - middle;
      const double wall = 4 + 0.4 * std::sin(1.7 * at.x + 0.4) * std::cos(1.9 * at.y);
      near += std::abs(at.z - wall) < 0.1 ? 1 : 0;
    }
    return static_cast<double>(near) / static_cast<double>(made.surface.positions.size());
  }
};

TEST_CASE("photographs become the surface that they show, far from the origin too, and without points") {
  for (const bool with_points : {true, false}) {
    const WallScene scene(with_points ? glm::dvec3(4.1e6, -2e5, 3e6) : glm::dvec3(0), with_points);
    const SceneMesh made = scene.mesh();
    CHECK(made.source == MeshSource::photographs);
    CHECK(made.matched == 5);
    CHECK(made.surface.positions.size() > 1000);
    CHECK(scene.share_on_wall(made) > 0.85);
    CHECK(made.trust.pixels_covered > 0.9);
  }
}

TEST_CASE("photographs that are held out, or too many, give no depths") {
  WallScene scene;
  scene.options.hold_out = HoldOut{2, 1};
  CHECK(scene.mesh().matched == 2);
  scene.options.hold_out.reset();
  scene.options.most_photographs = 3;
  CHECK(scene.mesh().matched == 3);
  scene.options.most_photographs = 1;
  CHECK_THROWS_WITH(scene.mesh(), "most_photographs: 1, must be 2 or more");
  scene.options.most_photographs = 200;
  fs::remove(scene.folder / "images/0.png");
  CHECK_THROWS_AS(scene.mesh(), InputError);
}

TEST_CASE("a given mesh is kept and gets what it lacks") {
  WallScene scene;
  const SceneMesh whole = scene.mesh();
  TriangleSoup half = whole.surface;
  std::erase_if(half.faces, [&](const glm::uvec3& face) { return half.positions[face[0]].x > 0; });
  {
    std::ofstream file(scene.folder / "half.ply", std::ios::binary);
    write_ply(file, half);
  }
  const std::string before = bytes_of(scene.folder / "half.ply");
  scene.options.complete = scene.folder / "half.ply";
  const SceneMesh both = scene.mesh();
  REQUIRE(both.completion);
  CHECK(both.completion->covered_before < 0.7);
  CHECK(both.completion->covered > 0.9);
  CHECK(both.surface.faces.size() == half.faces.size() + both.completion->added_faces);
  CHECK(bytes_of(scene.folder / "half.ply") == before);
  scene.options.complete = scene.folder / "nowhere.ply";
  CHECK_THROWS_AS(scene.mesh(), InputError);
}

TEST_CASE("photographs that show nothing in common are refused in one sentence") {
  const WallScene scene(glm::dvec3(0), false);
  for (int i = 0; i < 5; ++i) {
    const Photograph white{240, 180, std::vector<std::uint8_t>(3 * 240 * 180, 255), {}};
    write_image(scene.folder / "images" / (std::to_string(i) + ".png"), white);
  }
  CHECK_THROWS_WITH(scene.mesh(), Catch::EndsWith("its 5 photographs show too little of the same to take depths from"));
}

TEST_CASE("a point behind a camera that is said to have seen it does no harm") {
  WallScene scene;
  std::vector<WrittenView> written;
  std::vector<TrackedPoint> tracked;
  for (int i = 0; i < 5; ++i) written.push_back({std::to_string(i) + ".png", camera_on_arc(6.0 * i - 12)});
  const Relief relief;
  for (const glm::dvec3& point : relief.points(camera_on_arc(0), 8, 6)) {
    tracked.push_back({point, {0, 0, 0}, {{0, {1, 1}}, {1, {1, 1}}, {2, {1, 1}}}});
  }
  tracked.push_back({written[2].camera.center(), {0, 0, 0}, {{2, {1, 1}}, {3, {1, 1}}}});
  tracked.push_back({{0, 0, -4}, {0, 0, 0}, {{0, {1, 1}}, {1, {1, 1}}}});
  write_colmap_model(scene.folder / "sparse", written, tracked);
  CHECK(scene.share_on_wall(scene.mesh()) > 0.85);
}

TEST_CASE("one photograph makes no mesh, and a scene without depth images none of these") {
  WallScene scene;
  scene.options.hold_out = HoldOut{2, 4};
  CHECK_THROWS_WITH(scene.mesh(), Catch::EndsWith("to take depths from, there are 1 beside those held out"));
  scene.options.hold_out.reset();
  scene.options.from = MeshSource::depth_images;
  CHECK_THROWS_WITH(scene.mesh(), Catch::EndsWith("has no depth images to make a mesh of"));
}

}  // namespace
}  // namespace lumatlas
