// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/scene_mesh.h"

#include <catch2/catch.hpp>
#include <stdexcept>

#include "mesh/base/errors.h"
#include "mesh/readers/mesh_file.h"
#include "tests/support/colmap_bytes.h"
#include "tests/support/scenes/surfaces.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/meshing/seen_sphere.h"
#include "tools/scene/forms/colmap/colmap_writer.h"

namespace lumatlas {
namespace {

// A COLMAP workspace of the sphere, whose middle is at `offset`.
struct SphereScene {
  TemporaryFolder folder;

  explicit SphereScene(bool with_tracks, const glm::dvec3& offset = glm::dvec3(0)) {
    std::filesystem::create_directories(folder / "images");
    std::filesystem::create_directories(folder / "sparse");
    const std::vector<glm::dvec3> points = sphere_points(3000);
    const std::vector<Camera> views = views_around(20);
    const auto seen = views_that_see(points, views);
    std::vector<WrittenView> written;
    for (std::size_t i = 0; i < views.size(); ++i) {
      const std::string name = std::to_string(10 + i) + ".png";
      Photograph grey{400, 400, std::vector<std::uint8_t>(3 * 400 * 400, 90), {}};
      write_image(folder / "images" / name, grey);
      Camera view = views[i];
      view.cam_from_world_translation -= view.cam_from_world_rotation * offset;
      written.push_back({name, view});
    }
    std::vector<TrackedPoint> tracked;
    for (std::size_t i = 0; i < points.size(); ++i) {
      TrackedPoint point{points[i] + offset, {200, 100, 50}, {}};
      for (const std::uint32_t view : seen[i]) {
        if (with_tracks) point.track.push_back({view, {1, 1}});
      }
      tracked.push_back(point);
    }
    write_colmap_model(folder / "sparse", written, tracked);
  }
};

const SceneMeshOptions kOfPoints = [] {
  SceneMeshOptions options;
  options.from = MeshSource::points;
  return options;
}();

const StageProgress kUnreported = [](const std::string&, std::size_t) { return [](std::size_t) {}; };

Mesh centred(const TriangleSoup& soup, const glm::dvec3& offset) {
  Mesh mesh;
  for (const glm::dvec3& position : soup.positions) mesh.positions.emplace_back(position - offset);
  mesh.faces = soup.faces;
  return mesh;
}

TEST_CASE("a model's points with their tracks become the surface, with colours, and are trusted") {
  const SphereScene scene(true);
  const SceneMesh made = mesh_from_scene(scene.folder.path(), kOfPoints, kUnreported);
  CHECK(made.points == 3000);
  CHECK(made.views == 20);
  CHECK_FALSE(made.views_estimated);
  CHECK(made.points_file == scene.folder / "sparse/points3D.bin");
  CHECK(volume_of(centred(made.surface, glm::dvec3(0))) == Approx(4.18879).epsilon(0.02));
  REQUIRE(made.surface.colors.size() == made.surface.positions.size());
  CHECK(made.surface.colors.front() == glm::u8vec3(200, 100, 50));
  CHECK(made.trust.points_on_surface > 0.95);
  CHECK(made.trust.pixels_guessed == 0);
  // The sphere's disc: sin = 1/5, of radius 800 * tan, of 400 x 400 pixels.
  CHECK(made.trust.pixels_covered == Approx(0.523).margin(0.02));
  CHECK(made.warnings.empty());
}

TEST_CASE("photographs that the mesh leaves mostly empty are warned of, with their share and the emptiest") {
  SurfaceTrust trust;
  trust.pixels_covered = 0.7;
  const std::vector<std::string> names{"a.jpg", "b.jpg"};
  CHECK(coverage_warning(trust, names, "points").empty());
  trust.frames_mostly_empty = 0.25;
  trust.emptiest_covered = 0.12;
  trust.emptiest_view = 1;
  CHECK(coverage_warning(trust, names, "points") ==
        "the mesh covers only 70% of the photographs' pixels, and less than half of 25% of the photographs, least of "
        "b.jpg (12%): the rest stays empty, for lack of points there");
  // One camera sees all of the sphere, and the other looks past it.
  const SphereScene scene(true);
  const SceneMesh made = mesh_from_scene(scene.folder.path(), kOfPoints, kUnreported);
  const std::vector<Camera> near = views_around(1);
  Camera away = near[0];
  away.cx += 350;
  const SurfaceTrust seen = surface_trust(centred(made.surface, glm::dvec3(0)), {}, std::vector{near[0], away}, [] {});
  CHECK(seen.frames_mostly_empty == 0.5);
  CHECK(seen.emptiest_view == 1);
  CHECK(seen.emptiest_covered < 0.3);
}

TEST_CASE("points without tracks, and far from the origin, become the same surface within a hundredth") {
  const glm::dvec3 far(4.5e6, -5.4e6, 200);
  const SphereScene scene(false, far);
  const SceneMesh made = mesh_from_scene(scene.folder.path(), kOfPoints, kUnreported);
  CHECK(made.views_estimated);
  CHECK(volume_of(centred(made.surface, far)) == Approx(4.18879).epsilon(0.02));
}

TEST_CASE("a PLY of points takes the place of the model's, with a fused.ply found by its name") {
  const SphereScene scene(true);
  std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 1201\nproperty double x\nproperty double y\nproperty double z\n"
      "property float nx\nproperty float ny\nproperty float nz\nend_header\nnan 0 0 0 0 1\n";
  for (const glm::dvec3& p : sphere_points(1200)) {
    const std::string xyz = std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z);
    ply += xyz + " " + xyz + "\n";
  }
  const auto fused = scene.folder.with_file("fused.ply", ply);
  const SceneMesh found = mesh_from_scene(scene.folder.path(), kOfPoints, kUnreported);
  CHECK(found.points == 1200);
  CHECK(found.points_file == fused);
  CHECK(found.views_estimated);
  CHECK(volume_of(centred(found.surface, glm::dvec3(0))) == Approx(4.18879).epsilon(0.03));
  SceneMeshOptions options = kOfPoints;
  options.points = fused;
  CHECK(mesh_from_scene(scene.folder.path(), options, kUnreported).surface.faces == found.surface.faces);
}

TEST_CASE("of too many points the spacing is widened until they are few enough") {
  const SphereScene scene(true);
  SceneMeshOptions options = kOfPoints;
  options.spacing_px = 0;
  options.most_points = 500;
  const SceneMesh made = mesh_from_scene(scene.folder.path(), options, kUnreported);
  CHECK(made.points_used <= 500);
  CHECK(made.points_used > 200);
  CHECK(made.spacing_px > 1);
  CHECK(volume_of(centred(made.surface, glm::dvec3(0))) == Approx(4.18879).epsilon(0.05));
}

TEST_CASE("faces longer than the bound are left out") {
  const SphereScene scene(true);
  SceneMeshOptions options = kOfPoints;
  options.longest_edge = 1;  // about half of them
  const SceneMesh all = mesh_from_scene(scene.folder.path(), kOfPoints, kUnreported);
  const SceneMesh few = mesh_from_scene(scene.folder.path(), options, kUnreported);
  CHECK(10 * few.surface.faces.size() < 6 * all.surface.faces.size());
  CHECK(few.trust.pixels_covered < all.trust.pixels_covered);
}

TEST_CASE("points that make no surface, and files that are none, get one sentence") {
  const SphereScene scene(true);
  const auto complaint = [&](const std::string& ply) {
    SceneMeshOptions options = kOfPoints;
    options.points = scene.folder.with_file("points.ply", ply);
    try {
      (void)mesh_from_scene(scene.folder.path(), options, kUnreported);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  const std::string head = "ply\nformat ascii 1.0\nelement vertex ";
  const std::string xyz = "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  CHECK_THAT(complaint(head + "3" + xyz + "0 0 0\n1 0 0\n0 1 0\n"), Catch::Contains("3 points make no surface"));
  CHECK_THAT(complaint(head + "1" + xyz + "nan 0 0\n"), Catch::Contains("none of its vertices is finite"));
  CHECK_THAT(complaint(head + "9" + xyz + "0 0 0\n"), Catch::Contains("points.ply"));
  CHECK_THAT(complaint(head + "0" + xyz), Catch::Contains("has no vertices"));
  CHECK_THAT(complaint("rubbish"), Catch::Contains("points.ply"));
  CHECK_THAT(complaint(head + "4" + xyz + "1e300 0 0\n0 1e300 0\n0 0 1e300\n1 1 1\n"), Catch::Contains("points.ply"));
}

TEST_CASE("what the progress throws ends the work") {
  const SphereScene scene(true);
  const StageProgress stops = [](const std::string&, std::size_t) {
    return [](std::size_t) { throw std::runtime_error("stop"); };
  };
  CHECK_THROWS_WITH(mesh_from_scene(scene.folder.path(), kOfPoints, stops), "stop");
}

TEST_CASE("options that break a rule are refused by name") {
  SceneMeshOptions options = kOfPoints;
  options.spacing_px = -1;
  CHECK_THROWS_WITH(check(options), "spacing_px: -1, must be in [0, 1000]");
  options = {};
  options.longest_edge = 0.5;
  CHECK_THROWS_WITH(check(options), "longest_edge: 0.5, must be in [1, 1000000]");
  options = {};
  options.most_points = 3;
  CHECK_THROWS_WITH(check(options), "most_points: 3, must be 4 or more");
}

}  // namespace
}  // namespace lumatlas
