// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of every kind of synthetic scene and every trajectory, and the promises of each.
#include "tools/lab/synth/kinds.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mesh/readers/mesh_file.h"
#include "mesh/visibility/visibility.h"
#include "tests/support/scenes/synth_files.h"
#include "tests/support/temporary_folder.h"
#include "tools/lab/synth/errors/passer_by.h"
#include "tools/lab/synth/random.h"
#include "tools/lab/synth/synth.h"
#include "tools/lab/synth/tracer.h"
#include "tools/scene/scene.h"

namespace lumatlas {
namespace {

SynthOptions small_options(SynthKind kind) {
  SynthOptions options;
  options.kind = kind;
  options.views = 3;
  options.width = 48;
  options.height = 36;
  options.samples = 2;
  options.triangles = 30000;
  return options;
}

std::vector<SynthKind> all_kinds() {
  std::vector<SynthKind> kinds;
  for (const SynthKindRow& row : synth_kinds()) kinds.push_back(row.kind);
  return kinds;
}

std::vector<SynthTrajectory> all_trajectories() {
  std::vector<SynthTrajectory> trajectories;
  for (const SynthTrajectoryRow& row : synth_trajectories()) trajectories.push_back(row.trajectory);
  return trajectories;
}

// The laboratory, whose scan is long work, has a test of its own.
TEST_CASE("every kind has the same bytes for any number of threads, and others for another seed") {
  SynthOptions options =
      small_options(GENERATE(filter([](SynthKind kind) { return kind != SynthKind::lab; }, from_range(all_kinds()))));
  options.trajectory = SynthTrajectory::hilbert;
  options.path_frames = 1;
  options.test_views = 2;
  const auto one = written(options, 1);
  CHECK(one.size() == 3 + 3 + 1 + (1 + 3) + (2 + 3));  // pictures, sparse model, mesh
  CHECK((one == written(options, 2)));
  options.seed = 2;
  const auto other = written(options, 2);
  for (const char* const name : {"images/0000.png", "mesh.ply", "test/images/0001.png"})
    CHECK(one.at(name) != other.at(name));
}

TEST_CASE("bad trajectories and test views are refused by name") {
  CHECK(synth_trajectory_named("orbit") == SynthTrajectory::orbit);
  CHECK_THROWS_WITH(synth_trajectory_named("sweep"),
                    "synth: trajectory is sweep, must be one of walk, hilbert, orbit, random");
  SynthOptions options;
  CHECK(std::string(synth_trajectory(options).name) == "walk");
  options.kind = SynthKind::village;
  CHECK(std::string(synth_trajectory(options).name) == "hilbert");
  options.test_views = 100001;
  CHECK_THROWS_WITH(check(options), "synth: test_views is 100001, must be in [0, 100000]");
}

// ---- The mesh.

glm::dvec3 corner_of(const Mesh& mesh, std::uint32_t vertex) {
  return glm::dvec3(mesh.positions[vertex]);
}

glm::dvec3 face_area_vector(const Mesh& mesh, const glm::uvec3& f) {
  return 0.5 * glm::cross(corner_of(mesh, f.y) - corner_of(mesh, f.x), corner_of(mesh, f.z) - corner_of(mesh, f.x));
}

bool is_well_shaped(const Mesh& mesh, const glm::uvec3& f) {  // height above 1e-4 of the longest side
  const double a = glm::distance(corner_of(mesh, f.x), corner_of(mesh, f.y));
  const double b = glm::distance(corner_of(mesh, f.y), corner_of(mesh, f.z));
  const double c = glm::distance(corner_of(mesh, f.z), corner_of(mesh, f.x));
  const double longest = std::max({a, b, c});
  return 2 * glm::length(face_area_vector(mesh, f)) > 1e-4 * longest * longest;
}

TEST_CASE("every kind's mesh is manifold, oriented towards the air, without degenerate faces or unused vertices") {
  const synth::Scene scene = synth::make_scene(small_options(GENERATE(from_range(all_kinds()))));
  const Mesh& mesh = scene.geometry.mesh;
  REQUIRE(scene.geometry.surface_of_face.size() == mesh.faces.size());
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  std::vector<bool> used(mesh.positions.size(), false);
  std::size_t bad = 0;
  std::size_t turned = 0;
  std::size_t shared_twice = 0;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const glm::uvec3& f = mesh.faces[i];
    for (int k = 0; k < 3; ++k) {
      used[f[k]] = true;
      if (!edges.insert({f[k], f[(k + 1) % 3]}).second) ++shared_twice;
    }
    if (!is_well_shaped(mesh, f)) ++bad;
    const synth::Surface& surface = scene.geometry.surfaces[scene.geometry.surface_of_face[i]];
    const glm::vec3 middle = (mesh.positions[f.x] + mesh.positions[f.y] + mesh.positions[f.z]) / 3.0F;
    const glm::dvec3 normal = glm::normalize(face_area_vector(mesh, f));
    if (glm::dot(normal, glm::dvec3(synth::normal(surface, middle))) < 0.98) ++turned;
  }
  CHECK(bad == 0);
  CHECK(turned == 0);
  CHECK(shared_twice == 0);
  CHECK(std::count(used.begin(), used.end(), false) == 0);
}

std::vector<double> area_per_surface(const synth::Tessellation& geometry) {
  std::vector<double> area(geometry.surfaces.size(), 0);
  for (std::size_t i = 0; i < geometry.mesh.faces.size(); ++i) {
    area[geometry.surface_of_face[i]] += glm::length(face_area_vector(geometry.mesh, geometry.mesh.faces[i]));
  }
  return area;
}

TEST_CASE("the triangle target changes how finely a scene is cut, not its shape") {
  SynthOptions options = small_options(GENERATE(from_range(all_kinds())));
  const synth::Scene coarse = synth::make_scene(options);
  options.triangles = 300000;
  const synth::Scene fine = synth::make_scene(options);
  CHECK(static_cast<double>(coarse.geometry.mesh.faces.size()) == Approx(30000).epsilon(0.1));
  CHECK(static_cast<double>(fine.geometry.mesh.faces.size()) == Approx(300000).epsilon(0.1));
  const std::vector<double> expected = area_per_surface(coarse.geometry);
  const std::vector<double> area = area_per_surface(fine.geometry);
  REQUIRE(area.size() == expected.size());
  for (std::size_t i = 0; i < area.size(); ++i) {
    CHECK(std::abs(area[i] - expected[i]) < 1e-3 * expected[i] + 1e-6);  // float corners
  }
}

TEST_CASE("the paper's numbers of triangles are met within a tenth by every kind") {
  const synth::Scene scene = synth::make_scene(small_options(GENERATE(from_range(all_kinds()))));
  for (const double triangles : {1.6e6, 6.1e6, 10.3e6}) {
    const double edge = synth::edge_for_faces(scene.solids, triangles);
    CHECK(synth::count_faces(scene.solids, edge) == Approx(triangles).epsilon(0.1));
  }
}

// ---- The pictures.

TEST_CASE("what a pixel shows is where the true mesh is that was written") {
  SynthOptions options = small_options(GENERATE(from_range(all_kinds())));
  options.trajectory = SynthTrajectory::random;
  if (options.kind == SynthKind::lab) options.triangles = 3000;  // a finer scan is long work
  const TemporaryFolder folder;
  write_synthetic_scene(options, folder.path());
  const synth::Scene scene = synth::make_scene(options);
  const synth::Tracer tracer(scene);
  const bool scanned = std::filesystem::exists(folder / "truth/mesh.ply");
  CHECK(scanned == (options.kind == SynthKind::lab));
  const TriangleSoup soup = read_triangle_soup(folder / (scanned ? "truth/mesh.ply" : "mesh.ply"));
  Mesh mesh;
  mesh.positions.assign(soup.positions.begin(), soup.positions.end());
  mesh.faces = soup.faces;
  const auto visibility = make_ray_visibility(mesh);
  std::size_t other = 0;  // a ray at a silhouette may go the other way by rounding
  std::size_t pixels = 0;
  for (const SceneView& view : read_scene_views(folder.path(), glm::dvec3(0)).views) {
    const VisibilityBuffer visible = visibility->trace(view.camera);
    for (std::uint32_t y = 0; y < options.height; ++y) {
      for (std::uint32_t x = 0; x < options.width; ++x, ++pixels) {
        const float depth = visible.depth[std::size_t{y} * options.width + x];
        const auto point = tracer.surface_at(view.camera, {x + 0.5, y + 0.5});
        const double expected = point ? view.camera.cam_from_world(*point).z : HUGE_VAL;
        if (point ? std::abs(depth - expected) > 1e-4 * expected : std::isfinite(depth)) ++other;
      }
    }
  }
  CHECK(pixels == 3UL * 48 * 36);
  CHECK(other < pixels / 500);
}

TEST_CASE("beyond the village there is the sky, and no mesh") {
  SynthOptions options = small_options(SynthKind::village);
  options.trajectory = SynthTrajectory::walk;
  options.samples = 16;
  options.width = 192;
  options.height = 144;
  const synth::Scene scene = synth::make_scene(options);
  const synth::Tracer tracer(scene);
  const Camera camera = synth::cameras_on_trajectory(scene, tracer, options)[0];
  const Photograph photo = tracer.photograph(camera, options.samples, 1);
  const VisibilityBuffer visible = make_ray_visibility(scene.geometry.mesh)->trace(camera);
  std::size_t sky = 0;
  for (std::uint32_t x = 1; x + 1 < options.width; ++x) {  // the uppermost row, away from roofs
    if (visible.face[x - 1] != FaceId::none || visible.face[x] != FaceId::none || visible.face[x + 1] != FaceId::none)
      continue;
    ++sky;
    const glm::vec3 expected =
        synth::sky_color(*scene.sky, glm::vec3(glm::normalize(camera.ray(glm::dvec2(x + 0.5, 0.5)))));
    for (int channel = 0; channel < 3; ++channel)  // the mean over a pixel
      CHECK(std::abs(photo.rgb[3 * std::size_t{x} + channel] - synth::srgb_from_linear(expected[channel])) < 12);
  }
  CHECK(sky > 30);
}

TEST_CASE("the village is mostly diffuse, with windows that shine a little") {
  const synth::Scene scene = synth::make_village(1, 30000);
  const auto glossy = std::count_if(scene.materials.begin(), scene.materials.end(),
                                    [](const synth::Material& m) { return m.gloss > 0 && m.gloss < 0.2F; });
  const auto shiny = std::count_if(scene.materials.begin(), scene.materials.end(),
                                   [](const synth::Material& m) { return m.gloss >= 0.2F || m.metal; });
  CHECK(glossy > 100);
  CHECK(shiny == 0);
  const std::vector<double> area = area_per_surface(scene.geometry);
  double all = 0;
  double gloss = 0;
  for (std::size_t i = 0; i < area.size(); ++i) {
    all += area[i];
    if (scene.materials[scene.geometry.surfaces[i].material].gloss > 0) gloss += area[i];
  }
  CHECK(gloss > 0.01 * all);
  CHECK(gloss < 0.1 * all);
}

// ---- The cameras.

TEST_CASE("on every trajectory of every kind cameras are valid, level and in the open") {
  SynthOptions options = small_options(GENERATE(from_range(all_kinds())));
  options.trajectory = GENERATE(from_range(all_trajectories()));
  options.views = 150;
  options.seed = GENERATE(1, 2, 3);
  const synth::Scene scene = synth::make_scene(options);
  const synth::Tracer tracer(scene);
  const std::vector<Camera> cameras = synth::cameras_on_trajectory(scene, tracer, options);
  REQUIRE(cameras.size() == 150);
  for (const Camera& camera : cameras) {
    CHECK_NOTHROW(check(camera));
    const glm::dmat3 world_from_cam = glm::transpose(camera.cam_from_world_rotation);
    CHECK(std::abs(world_from_cam[0].z) < 1e-12);
    CHECK(world_from_cam[1].z < 0);
    CHECK(synth::is_free(scene, tracer, camera.center(), 0.2));
  }
}

TEST_CASE("the Hilbert flight covers the village evenly in equal steps") {
  SynthOptions options = small_options(SynthKind::village);
  options.views = 200;
  const synth::Scene scene = synth::make_scene(options);
  const std::vector<Camera> cameras = synth::cameras_on_trajectory(scene, synth::Tracer(scene), options);
  std::map<std::pair<int, int>, int> visits;  // of the squares of a grid of 4 x 4 over the flight's
  double shortest = HUGE_VAL;
  double longest = 0;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const glm::dvec2 share =
        glm::dvec2(cameras[i].center() - scene.flight.corner) / glm::dvec2(scene.flight.along + scene.flight.aside);
    ++visits[{static_cast<int>(std::floor(4 * share.x)), static_cast<int>(std::floor(4 * share.y))}];
    if (i == 0) continue;
    const double step = glm::distance(cameras[i].center(), cameras[i - 1].center());
    shortest = std::min(shortest, step);
    longest = std::max(longest, step);
  }
  CHECK(visits.size() == 16);
  for (const auto& [square, count] : visits) CHECK(std::abs(count - 12.5) < 4);
  CHECK(longest < 1.25 * shortest);  // chords of round corners
}

TEST_CASE("a walk through the village keeps to its streets at eye level") {
  SynthOptions options = small_options(SynthKind::village);
  options.trajectory = SynthTrajectory::walk;
  options.views = 400;
  const synth::Scene scene = synth::make_scene(options);
  const synth::Tracer tracer(scene);
  const std::vector<Camera> cameras = synth::cameras_on_trajectory(scene, tracer, options);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const glm::dvec3 at = cameras[i].center();
    CHECK(at.z == Approx(1.7));
    CHECK(std::min(std::abs(std::abs(at.x) - 11), std::abs(std::abs(at.y) - 11)) < 2);
    CHECK(tracer.sees(at, cameras[(i + 1) % cameras.size()].center()));
  }
}

TEST_CASE("an orbit looks at the middle from all sides") {
  SynthOptions options = small_options(SynthKind::village);
  options.trajectory = SynthTrajectory::orbit;
  options.views = 12;
  const synth::Scene scene = synth::make_scene(options);
  const std::vector<Camera> cameras = synth::cameras_on_trajectory(scene, synth::Tracer(scene), options);
  glm::dvec3 sum(0);
  for (const Camera& camera : cameras) {
    const glm::dvec2 at = camera.image_from_cam(camera.cam_from_world(scene.orbit.middle));
    CHECK(glm::distance(at, glm::dvec2(camera.cx, camera.cy)) < 1e-9);
    sum += camera.center() - scene.orbit.middle;
  }
  CHECK(glm::length(glm::dvec2(sum)) < 1e-6);
}

TEST_CASE("random poses are spread over the scene and see surface, and those of the test are others") {
  SynthOptions options = small_options(GENERATE(from_range(all_kinds())));
  options.trajectory = SynthTrajectory::random;
  options.views = options.test_views = 100;
  const synth::Scene scene = synth::make_scene(options);
  const synth::Tracer tracer(scene);
  const std::vector<Camera> cameras = synth::cameras_on_trajectory(scene, tracer, options);
  const std::vector<Camera> tests = synth::test_cameras(scene, tracer, options);
  REQUIRE(tests.size() == 100);
  const auto visibility = make_ray_visibility(scene.geometry.mesh);
  glm::dvec3 low(HUGE_VAL);
  glm::dvec3 high(-HUGE_VAL);
  for (std::size_t i = 0; i < tests.size(); ++i) {
    CHECK(glm::distance(tests[i].center(), cameras[i].center()) > 1e-3);
    low = glm::min(low, tests[i].center());
    high = glm::max(high, tests[i].center());
    const VisibilityBuffer visible = visibility->trace(tests[i]);
    const auto seen = visible.face.size() - std::count(visible.face.begin(), visible.face.end(), FaceId::none);
    CHECK(static_cast<double>(seen) > 0.6 * static_cast<double>(visible.face.size()));
  }
  for (int axis = 0; axis < 3; ++axis)
    CHECK(high[axis] - low[axis] > 0.6 * (scene.stay.high[axis] - scene.stay.low[axis]));
}

TEST_CASE("test views are a workspace of random poses with their true pictures") {
  SynthOptions options = small_options(SynthKind::wall);
  options.test_views = 2;
  options.disturbances.exposure_noise = 1;
  const TemporaryFolder folder;
  write_synthetic_scene(options, folder.path());
  const SceneViews test = read_scene_views(folder / "test", glm::dvec3(0));
  const synth::Scene scene = synth::make_scene(options);
  const synth::Tracer tracer(scene);
  const std::vector<Camera> cameras = synth::test_cameras(scene, tracer, options);
  REQUIRE(test.views.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(glm::distance(test.views[i].camera.center(), cameras[i].center()) < 1e-9);
    CHECK(load_photograph(test.views[i]).rgb ==
          tracer.photograph(cameras[i], 4 * options.samples, synth::hashed(options.seed, 4, i)).rgb);
  }
  CHECK_FALSE(std::filesystem::exists(folder / "test/mesh.ply"));
}

TEST_CASE("a trajectory that leads through solids alone is refused") {
  SynthOptions options = small_options(SynthKind::apartment);
  synth::Scene scene = synth::make_scene(options);
  const synth::Tracer tracer(scene);
  scene.flight.corner = {0, 0, 50};
  scene.stay.low = scene.stay.high = {0, 0, 50};
  options.trajectory = SynthTrajectory::hilbert;
  CHECK_THROWS_WITH(synth::cameras_on_trajectory(scene, tracer, options),
                    "scene: no part of the trajectory hilbert is in the open");
  options.trajectory = SynthTrajectory::random;
  CHECK_THROWS_WITH(synth::cameras_on_trajectory(scene, tracer, options),
                    "scene: no random pose sees surface, in 10000 attempts");
}

}  // namespace
}  // namespace lumatlas
