// SPDX-License-Identifier: GPL-3.0-or-later
// A build adds to half a wall what photographs show of the other half.
#include "tools/pipeline/surface/completed_surface.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>

#include "mesh/readers/mesh_file.h"
#include "tests/support/scenes/relief_scenes.h"
#include "tests/support/temporary_folder.h"
#include "tools/pipeline/build_model.h"
#include "tools/scene/forms/colmap/colmap_writer.h"
#include "tools/stereo/scene_stereo.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

// A flat grid in the middle of the wall's relief, for x up to `right`.
TriangleSoup wall_up_to(double right) {
  constexpr int kSide = 80;
  TriangleSoup soup;
  for (int y = 0; y <= kSide; ++y) {
    for (int x = 0; x <= kSide; ++x) {
      const double u = -4 + 0.1 * x, v = -4 + 0.1 * y;
      soup.positions.emplace_back(u, v, 4 + 0.4 * std::sin(1.7 * u + 0.4) * std::cos(1.9 * v));
    }
  }
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      if (-4 + 0.1 * (x + 1) > right) continue;
      const auto a = static_cast<std::uint32_t>((kSide + 1) * y + x), b = a + kSide + 1;
      soup.faces.emplace_back(a, b, a + 1);
      soup.faces.emplace_back(a + 1, b, b + 1);
    }
  }
  return soup;
}

enum class Shown { wall, nothing, uneven_wall };  // `uneven_wall`: each photograph is as bright as 1, or 0.2 of it

// A COLMAP workspace of five photographs of the wall, and a mesh of part of it.
struct HalfWall {
  TemporaryFolder folder;
  BuildOptions options;

  // Shown::nothing: white photographs, and no points.
  explicit HalfWall(double right, Shown shown = Shown::wall) {
    const bool white = shown == Shown::nothing;
    fs::create_directories(folder / "images");
    fs::create_directories(folder / "sparse");
    const Relief relief;
    std::vector<WrittenView> written;
    for (int i = 0; i < 5; ++i) {
      const Camera camera = camera_on_arc(6.0 * i - 12);
      const std::string name = std::to_string(i) + ".png";
      const double exposure = shown == Shown::uneven_wall && i % 2 == 1 ? 0.2 : 1;
      Photograph photograph = relief.photograph(camera, glm::dvec3(exposure));
      if (white) std::fill(photograph.rgb.begin(), photograph.rgb.end(), std::uint8_t{255});
      write_image(folder / "images" / name, photograph);
      written.push_back({name, camera});
    }
    std::vector<TrackedPoint> tracked;
    for (const glm::dvec3& point : relief.points(camera_on_arc(0), 8, 6)) {
      if (white) break;
      TrackedPoint seen{point, {200, 100, 50}, {}};
      for (std::uint32_t view = 0; view < 5; ++view) seen.track.push_back({view, {1, 1}});
      tracked.push_back(seen);
    }
    write_colmap_model(folder / "sparse", written, tracked);
    std::ofstream file(folder / "mesh.ply", std::ios::binary);
    write_ply(file, wall_up_to(right));
    options.texture_px.reset();
    options.completion.surface = true;
    options.completion.stereo_folder = folder / "stereo";
  }

  [[nodiscard]] BuildResult build(const BuildCallback& callback = {}) const {
    return build_model(folder.path(), options, callback);
  }
};

struct WallBuild {
  BuildResult result;
  std::size_t steps = 0;  // of finding what the mesh lacks
};

// Returns what a build makes of the wall's mesh up to `right`, built at the first call.
const WallBuild& built_up_to(double right) {
  static std::map<double, WallBuild> builds;
  const auto known = builds.find(right);
  if (known != builds.end()) return known->second;
  std::size_t steps = 0;
  BuildResult result = HalfWall(right).build([&](const BuildProgress& progress) {
    if (std::string(progress.stage) == "finding what the mesh lacks") ++steps;
    return true;
  });
  return builds.emplace(right, WallBuild{std::move(result), steps}).first->second;
}

TEST_CASE("a build adds the half of a wall that its mesh lacks, and says so") {
  CHECK(built_up_to(0).steps > 10);
  const BuildResult& completed = built_up_to(0).result;
  CHECK(completed.added_faces > 100);
  REQUIRE(completed.frames);
  const FrameShares& frames = *completed.frames;
  CHECK(frames.surface < 0.7);
  CHECK(frames.added > 0.2);
  CHECK(frames.surface + frames.added + frames.far > 0.93);
  CHECK(frames.surface + frames.added + frames.far <= 1);
  // The added surface lies on the wall.
  const Surface& surface = *completed.snapshot.surface;
  std::size_t added = 0, near = 0;
  for (const glm::vec3& position : near_surface(surface).mesh.positions) {
    const glm::dvec3 at = glm::dvec3(position) + surface.offset;
    if (at.x < 0.2 || at.x > 2 || std::abs(at.y) > 1.5) continue;  // where few photographs see it, it is less exact
    ++added;
    near += std::abs(at.z - 4 - 0.4 * std::sin(1.7 * at.x + 0.4) * std::cos(1.9 * at.y)) < 0.2 ? 1 : 0;
  }
  CHECK(added > 100);
  CHECK(10 * near > 8 * added);
  HalfWall scene(0);
  scene.options.completion.surface = false;
  const BuildResult given = scene.build();
  CHECK(given.added_faces == 0);
  REQUIRE(given.frames);
  CHECK(given.frames->added == 0);
  CHECK(given.frames->surface == frames.surface);
}

TEST_CASE("what a build would match for a mesh is known without matching") {
  for (const double right : {0.0, 4.0}) {
    const HalfWall scene(right);
    const MeshInput mesh = load_mesh(scene.folder.path(), std::nullopt, 0);
    const SceneViews views = read_scene_views(scene.folder.path(), mesh.offset);
    const CompletionPlan plan = plan_completion(views, {0, 1, 2, 3, 4}, mesh.mesh, mesh.offset);
    CHECK(plan.to_match == (right < 4 ? 5 : 0));
    const BuildResult& built = built_up_to(right).result;
    REQUIRE(built.frames);
    CHECK(plan.shares.surface == built.frames->surface);
    CHECK(plan.shares.added == 0);
    CHECK((built.added_faces > 0) == (plan.to_match > 0));
  }
}

TEST_CASE("photographs that differ more on the mesh than beside it are not matched for what it lacks") {
  const HalfWall scene(2.2, Shown::uneven_wall);
  const MeshInput mesh = load_mesh(scene.folder.path(), std::nullopt, 0);
  const SceneViews views = read_scene_views(scene.folder.path(), mesh.offset);
  const CompletionPlan plan = plan_completion(views, {0, 1, 2, 3, 4}, mesh.mesh, mesh.offset);
  CHECK(plan.shares.surface + plan.shares.far < 0.98);
  REQUIRE(plan.largest_gain_db);
  CHECK(*plan.largest_gain_db > 0);
  CHECK(*plan.largest_gain_db < 0.6);
  CHECK(plan.to_match == 0);
}

TEST_CASE("nothing is added to a mesh that fills the photographs") {
  const BuildResult& whole = built_up_to(4).result;
  CHECK(whole.added_faces == 0);
  REQUIRE(whole.frames);
  CHECK(whole.frames->surface > 0.99);
  CHECK(whole.snapshot.surface->far_faces == 0);
}

TEST_CASE("a build that is stopped while it looks for what the mesh lacks goes on where it was") {
  const HalfWall scene(0);
  std::size_t steps = 0;
  const BuildCallback until_fourth = [&](const BuildProgress& progress) {
    if (std::string(progress.stage) == "finding what the mesh lacks") ++steps;
    return steps < 4;
  };
  CHECK_THROWS_AS(scene.build(until_fourth), BuildStopped);
  CHECK(fs::exists(scene.folder / "stereo"));
  CHECK(scene.build().added_faces == built_up_to(0).result.added_faces);
  remove_stereo_work(scene.folder / "stereo");
  CHECK_FALSE(fs::exists(scene.folder / "stereo"));
}

TEST_CASE("a mesh that does not fit the photographs stays as it is") {
  const BuildResult result = HalfWall(0, Shown::nothing).build();
  REQUIRE(result.fit);
  CHECK_FALSE(result.fit->likely.empty());
  CHECK(result.added_faces == 0);
  CHECK(result.snapshot.surface->far_faces == 0);
  CHECK_FALSE(result.frames);
}

TEST_CASE("where depths cannot be had the mesh stays as it is, with a warning") {
  HalfWall scene(0);
  std::ofstream(scene.folder / "file") << "no folder";
  scene.options.completion.stereo_folder = scene.folder / "file" / "stereo";
  const BuildResult result = scene.build();
  CHECK(result.added_faces == 0);
  CHECK(std::any_of(result.warnings.begin(), result.warnings.end(), [](const std::string& warning) {
    return warning.starts_with("the mesh is used as given, although photographs show more: ");
  }));
}

TEST_CASE("the stereo of a build lies beside its model") {
  for (const char* const output : {"out/office", "out/office/", "out//office/."}) {
    CHECK(stereo_folder_of(output) == fs::path("out/office.stereo"));
  }
}

TEST_CASE("much that is filled is told with what to do") {
  CHECK(filled_frames_warning({0.6, 0.1, 0.1}).empty());
  CHECK_THAT(filled_frames_warning({0.5, 0.1, 0.1}),
             Catch::StartsWith("30% of the photographs' pixels see no surface") && Catch::Contains("take more"));
}

}  // namespace
}  // namespace lumatlas
