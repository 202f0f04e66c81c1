// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes and photographs that do not fit, made of one synthetic scene that does.
#include "tools/inspection/mesh_diagnosis.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <functional>
#include <glm/mat3x3.hpp>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>
#include <stdexcept>

#include "mesh/base/errors.h"
#include "mesh/readers/mesh_file.h"
#include "tests/support/temporary_folder.h"
#include "tools/inspection/inspection.h"
#include "tools/inspection/mesh_shift.h"
#include "tools/lab/synth/synth.h"
#include "tools/pipeline/build_model.h"
#include "tools/surface/surface_input.h"

namespace lumatlas {
namespace {

SynthOptions small_rooms(std::uint64_t seed) {
  SynthOptions options;
  options.seed = seed;
  options.views = 12;
  options.width = 120;
  options.height = 120;
  options.samples = 4;
  options.triangles = 4000;
  return options;
}

// Two rooms, square photographs.
const std::filesystem::path& rooms() {
  static const TemporaryFolder folder;
  static const bool made = [] {
    write_synthetic_scene(small_rooms(1), folder.path());
    return true;
  }();
  REQUIRE(made);
  return folder.path();
}

// The scene's mesh in the coordinates of its file.
Mesh mesh_of(const std::filesystem::path& scene) {
  MeshInput input = load_mesh(scene, std::nullopt);
  for (glm::vec3& position : input.mesh.positions) position = glm::vec3(glm::dvec3(position) + input.offset);
  return std::move(input.mesh);
}

Mesh changed(Mesh mesh, const glm::dmat3& linear, const glm::dvec3& shift = glm::dvec3(0)) {
  for (glm::vec3& position : mesh.positions) position = glm::vec3(linear * glm::dvec3(position) + shift);
  return mesh;
}

// `mesh` lies around `offset`.
MeshDiagnosis diagnosis_of(const std::filesystem::path& scene, const Mesh& mesh,
                           const glm::dvec3& offset = glm::dvec3(0), SurfaceInput facts = {}) {
  const SceneViews views = read_scene_views(scene, offset);
  std::vector<std::size_t> ranks(views.views.size());
  std::iota(ranks.begin(), ranks.end(), std::size_t{0});
  facts.mesh_file = "mesh.ply";
  return diagnose_mesh(scene, facts, mesh, offset, *make_ray_visibility(mesh), views.views, ranks);
}

// A copy of the scene whose photographs went through `change`.
void copy_with(const std::filesystem::path& folder, const std::function<Photograph(const Photograph&)>& change) {
  std::filesystem::copy(rooms(), folder, std::filesystem::copy_options::recursive);
  for (const auto& entry : std::filesystem::directory_iterator(folder / "images")) {
    write_image(entry.path(), change(read_photograph(entry.path(), Orientation::as_stored)));
  }
}

Photograph turned_right(const Photograph& image) {
  Photograph turned = image;
  for (std::size_t y = 0; y < image.height; ++y) {
    for (std::size_t x = 0; x < image.width; ++x) {
      for (std::size_t c = 0; c < 3; ++c) {
        turned.rgb[3 * (x * image.width + image.width - 1 - y) + c] = image.rgb[3 * (y * image.width + x) + c];
      }
    }
  }
  return turned;
}

TEST_CASE("a mesh that fits is not suspected, nor one whose faces are turned round") {
  Mesh mesh = mesh_of(rooms());
  const MeshDiagnosis fits = diagnosis_of(rooms(), mesh);
  CHECK(fits.as_given.correlation > 0.4);
  CHECK(fits.as_given.outliers < 0.1);
  CHECK(fits.warnings.empty());
  CHECK(fits.likely.empty());
  CHECK(mesh_diagnosis_json(fits)["likely"].is_null());
  for (glm::uvec3& face : mesh.faces) std::swap(face.x, face.y);
  CHECK(diagnosis_of(rooms(), mesh).warnings.empty());
}

TEST_CASE("a mesh in other units, with other axes or mirrored is told, with the options that undo it") {
  struct Case {
    MeshFrame done;  // to the mesh
    const char* explanation;
    const char* options;
  };
  const glm::dmat3 to_y_up = parse_mesh_axes("x,z,-y");  // as exports that are y up have it
  const std::vector<Case> cases = {
      {{.scale = 1000}, "1000 times too large, as in millimetres for metres", "--mesh-scale 0.001"},
      {{.scale = 0.01}, "100 times too small, as in metres for centimetres", "--mesh-scale 100"},
      {{.scale = 1 / 0.0254}, "as in inches for metres", "--mesh-scale 0.0254"},
      {{.axes = to_y_up}, "y up where the poses are z up", "--mesh-axes x,-z,y"},
      {{.axes = parse_mesh_axes("-x,y,z")}, "probably mirrored", "--mesh-axes -x,y,z"},
      {{.axes = to_y_up, .scale = 1000},
       "millimetres for metres and has other axes than the poses",
       "--mesh-scale 0.001 --mesh-axes x,-z,y"},
  };
  const Mesh mesh = mesh_of(rooms());
  const double fits = diagnosis_of(rooms(), mesh).as_given.correlation;
  for (const Case& c : cases) {
    CAPTURE(c.options);
    const MeshDiagnosis wrong = diagnosis_of(rooms(), changed(mesh, c.done.scale * c.done.axes));
    CHECK_FALSE(wrong.as_given.correlation >= MeshDiagnosisOptions().least_correlation);
    REQUIRE(wrong.warnings.size() == 1);
    CHECK(wrong.misfit == wrong.warnings.front());
    CHECK_THAT(wrong.misfit, Catch::Contains("mesh.ply: does not fit the photographs: "));
    CHECK_THAT(wrong.misfit, Catch::Contains(c.explanation));
    CHECK_THAT(wrong.likely, Catch::EndsWith(std::string(": give ") + c.options));
    REQUIRE(wrong.likely_correlation);
    CHECK(*wrong.likely_correlation == Approx(fits).margin(0.02));  // floats of other sizes
    REQUIRE(wrong.remedy);
    CHECK(mesh_frame_options(*wrong.remedy) == c.options);
    CHECK(mesh_diagnosis_json(wrong)["remedy"] == mesh_frame_json(*wrong.remedy));
    CHECK(wrong.wrong_frame);
    CHECK_THROWS_WITH(require_right_frame(wrong), wrong.misfit + "; if it is right as it is, give --mesh-scale 1");
  }
}

TEST_CASE("what is told of a mesh that was moved already is the whole frame to give") {
  const glm::dmat3 to_y_up = parse_mesh_axes("x,z,-y");
  const Mesh still_y_up = changed(mesh_of(rooms()), to_y_up);  // after the shift
  SurfaceInput facts;
  facts.mesh_file = "mesh.ply";
  facts.frame = {.scale = 0.001, .shift = {-500000, 0, 4500000}};
  const MeshDiagnosis wrong = diagnosis_of(rooms(), still_y_up, glm::dvec3(0), facts);
  CHECK_THAT(wrong.likely, Catch::EndsWith("--mesh-scale 0.001 --mesh-axes x,-z,y --mesh-shift -500000,-4500000,0"));
}

// A copy of the scene without points.
void copy_without_points(const std::filesystem::path& folder) {
  std::filesystem::copy(rooms(), folder, std::filesystem::copy_options::recursive);
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().stem() == "points3D") std::filesystem::remove(entry.path());
  }
}

TEST_CASE("the shift of a mesh is found by the scene's points, and is whole where it was") {
  const Mesh mesh = mesh_of(rooms());
  const MeshDiagnosis far = diagnosis_of(rooms(), mesh, {4e5, 5e6, -40});
  CHECK(far.likely == "the mesh is probably shifted: give --mesh-shift -400000,-5000000,40");
  CHECK(far.wrong_frame);
  const MeshDiagnosis near = diagnosis_of(rooms(), changed(mesh, glm::dmat3(1.0), {1.5, -1, 0.5}));
  CHECK(near.likely == "the mesh is probably shifted: give --mesh-shift -1.5,1,-0.5");
  const MeshDiagnosis both = diagnosis_of(rooms(), changed(mesh, parse_mesh_axes("x,z,-y")), {4e5, 5e6, 0});
  CHECK(both.likely ==
        "the mesh is probably shifted and has other axes than the poses: give --mesh-axes x,-z,y --mesh-shift "
        "-400000,0,-5000000");
}

TEST_CASE("without points a mesh that is far away is told to be shifted, and one of another scene to be another") {
  const TemporaryFolder folder, other;
  copy_without_points(folder.path());
  const Mesh mesh = mesh_of(rooms());
  const MeshDiagnosis far = diagnosis_of(folder.path(), mesh, {4e5, 5e6, 0});
  CHECK_THAT(far.likely, Catch::Contains("its coordinates are probably shifted") && Catch::Contains("--mesh-shift"));
  CHECK_FALSE(far.remedy);
  CHECK(mesh_diagnosis_json(far)["remedy"].is_null());
  CHECK_FALSE(far.wrong_frame);
  const MeshDiagnosis near = diagnosis_of(folder.path(), changed(mesh, glm::dmat3(1.0), {1.5, -1, 0.5}));
  REQUIRE(near.warnings.size() == 1);
  CAPTURE(near.warnings.front());
  CHECK_THAT(near.likely, Catch::Contains("shifted or turned against the poses"));
  SynthOptions options = small_rooms(7);
  options.kind = SynthKind::lab;
  write_synthetic_scene(options, other.path());
  const MeshDiagnosis wrong = diagnosis_of(rooms(), mesh_of(other.path()));
  REQUIRE(wrong.warnings.size() == 1);
  CHECK_THAT(wrong.likely, Catch::Contains("probably the mesh of another scene"));
  CHECK_FALSE(wrong.wrong_frame);
}

TEST_CASE("a shift is estimated of points with noise and strays, and of nothing else") {
  const Mesh mesh = mesh_of(rooms());
  std::vector<glm::dvec3> points;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.01), stray(0, 5);
  const glm::dvec3 shift(-123456, 654321, 7.8);
  for (const glm::vec3& position : mesh.positions) {
    const double by = points.size() % 10 == 0 ? stray(random) : noise(random);
    points.push_back(glm::dvec3(position) + shift + by * glm::normalize(glm::dvec3(1, 2, 3)));
  }
  const std::optional<glm::dvec3> found = estimated_mesh_shift(mesh, points);
  REQUIRE(found);
  CHECK(glm::distance(*found, shift) < 0.01);
  points.resize(49);
  CHECK_FALSE(estimated_mesh_shift(mesh, points));
  CHECK_FALSE(estimated_mesh_shift(Mesh{}, std::vector<glm::dvec3>(100)));
  std::vector<glm::dvec3> cloud;
  for (int i = 0; i < 500; ++i) cloud.emplace_back(10 * stray(random), 10 * stray(random), 10 * stray(random));
  CHECK_FALSE(estimated_mesh_shift(mesh, cloud));
}

TEST_CASE("coordinates in steps that photographs show are told") {
  SurfaceInput facts;
  facts.mesh_file = "mesh.ply";
  facts.coordinate_step = 0.5;
  const MeshDiagnosis coarse = diagnosis_of(rooms(), mesh_of(rooms()), glm::dvec3(0), facts);
  REQUIRE(coarse.warnings.size() == 1);
  CHECK_THAT(coarse.warnings.front(), Catch::StartsWith("mesh.ply: its coordinates come in steps of 0.5, ") &&
                                          Catch::Contains("a pixel of the photographs shows 0.0") &&
                                          Catch::Contains("--mesh-shift X,Y,Z"));
  facts.coordinate_step = 1e-4;
  CHECK(diagnosis_of(rooms(), mesh_of(rooms()), glm::dvec3(0), facts).warnings.empty());
}

TEST_CASE("square photographs that were turned or mirrored after their poses were found are told") {
  const Mesh mesh = mesh_of(rooms());
  const TemporaryFolder turned, back, upside_down;
  copy_with(turned.path(), turned_right);
  CHECK_THAT(diagnosis_of(turned.path(), mesh).likely, Catch::Contains("turned by 90 degrees to the right"));
  copy_with(back.path(), [](const Photograph& image) { return turned_right(turned_right(turned_right(image))); });
  CHECK_THAT(diagnosis_of(back.path(), mesh).likely, Catch::Contains("turned by 90 degrees to the left"));
  copy_with(upside_down.path(), [](const Photograph& image) { return turned_right(turned_right(image)); });
  CHECK_THAT(diagnosis_of(upside_down.path(), mesh).likely, Catch::Contains("turned by 180 degrees"));
}

TEST_CASE("black borders are told and do not enter; dark corners of single photographs are none") {
  const Mesh mesh = mesh_of(rooms());
  const TemporaryFolder framed, corner;
  copy_with(framed.path(), [](const Photograph& image) {
    Photograph border = image;
    for (std::size_t i = 0; i < border.rgb.size(); ++i) {
      if (i / 3 % border.width < 6) border.rgb[i] = 0;
    }
    return border;
  });
  const MeshDiagnosis told = diagnosis_of(framed.path(), mesh);
  REQUIRE(told.warnings.size() == 1);
  CHECK_THAT(told.warnings.front(), Catch::Contains("black border") && Catch::Contains("5.0% of the pixels"));
  CHECK(told.black_border == Approx(0.05));
  CHECK(told.likely.empty());
  int copied = 0;
  copy_with(corner.path(), [&](const Photograph& image) {
    Photograph dark = image;
    if (++copied < 4) std::fill_n(dark.rgb.begin(), 3 * 10 * dark.width, std::uint8_t{0});
    return dark;
  });
  CHECK(diagnosis_of(corner.path(), mesh).warnings.empty());
}

TEST_CASE("points lie on a mesh that fits, and not on another") {
  const Mesh mesh = mesh_of(rooms());
  const SceneViews views = read_scene_views(rooms(), glm::dvec3(0));
  std::vector<std::size_t> ranks(views.views.size());
  std::iota(ranks.begin(), ranks.end(), std::size_t{0});
  ScenePoints points;
  for (const glm::vec3& position : mesh.positions) points.positions.emplace_back(position);
  points.views.resize(points.positions.size());
  const auto share = [&](const Mesh& of) {
    const auto visibility = make_ray_visibility(of);
    return MeshFitMeter(views.views, ranks, *visibility, glm::dvec3(0)).points_on_mesh(points, 0.05);
  };
  CHECK(share(mesh) > 0.7);  // but those that stand before others in every picture's pixels
  CHECK(share(changed(mesh, 0.01 * glm::dmat3(1.0))) < 0.2);
  points.positions.resize(40);
  points.views.resize(40);
  CHECK(std::isnan(share(mesh)));
}

TEST_CASE("build refuses a mesh in another frame, unless one is given, and then takes lenses as given") {
  const TemporaryFolder folder;
  const std::filesystem::path large = folder.path() / "large.ply", far = folder.path() / "far.ply";
  const Mesh mesh = mesh_of(rooms());
  write_ply(large, changed(mesh, 1000.0 * glm::dmat3(1.0)));
  write_ply(far, changed(mesh, glm::dmat3(1.0), {30000, 20000, 0}));
  BuildOptions options;
  options.mesh = large;
  CHECK_THROWS_WITH(build_model(rooms(), options),
                    Catch::Contains("give --mesh-scale 0.001") && Catch::Contains("give --mesh-scale 1"));
  options.mesh_frame = MeshFrame{};
  const BuildResult told = build_model(rooms(), options);
  REQUIRE(told.fit);
  CHECK_THAT(told.fit->likely, Catch::Contains("1000 times too large"));
  CHECK(std::count(told.warnings.begin(), told.warnings.end(), told.fit->misfit) == 1);
  CHECK_FALSE(told.options.refine_lenses);
  options.mesh = far;
  CHECK_THROWS_WITH(build_model(rooms(), options),
                    Catch::Contains("see next to nothing of it") && Catch::Contains("--mesh-shift -30000,-20000,0"));
  options.mesh = large;
  options.mesh_frame = MeshFrame{.scale = 0.001};
  const BuildResult moved = build_model(rooms(), options);
  CHECK(moved.warnings.empty());
  options.mesh.reset();
  options.mesh_frame.reset();
  const BuildResult fits = build_model(rooms(), options);
  CHECK(fits.warnings.empty());
  CHECK(fits.options.refine_lenses);
  REQUIRE(fits.fit);
  CHECK(fits.fit->likely.empty());
  CHECK(moved.summed_coverage == Approx(fits.summed_coverage).epsilon(5e-3));  // floats of other sizes
}

TEST_CASE("a build leaves black borders out, paints none of them and takes them for no lens") {
  const TemporaryFolder framed;
  copy_with(framed.path(), [](const Photograph& image) {
    Photograph border = image;
    for (std::size_t i = 0; i < border.rgb.size(); ++i) {
      if (i / 3 % border.width < 6) border.rgb[i] = 0;
    }
    return border;
  });
  const BuildResult result = build_model(framed.path(), BuildOptions());
  CHECK_THAT(result.warnings.front(), Catch::Contains("black border"));
  for (const auto& view : result.snapshot.views) {
    if (!view) continue;
    CHECK(view->mask->validity[3] == 0);
    CHECK(view->mask->validity[60 * view->camera.width + 5] == 0);
  }
  for (const RefinedLens& lens : result.lenses) CHECK_FALSE(lens.applied);
}

TEST_CASE("inspect tells how well photographs agree, and what does not fit") {
  const nlohmann::json fits = inspect_scene(rooms(), std::nullopt, MeshFrame(), CellOptions(), true);
  CHECK(fits["fit"]["correlation"].get<double>() > 0.4);
  CHECK(fits["fit"]["likely"].is_null());
  const TemporaryFolder folder;
  write_ply(folder.path() / "small.ply", changed(mesh_of(rooms()), 0.001 * glm::dmat3(1.0)));
  const nlohmann::json wrong = inspect_scene(rooms(), folder.path() / "small.ply", MeshFrame(), CellOptions(), true);
  CHECK_THAT(wrong["fit"]["likely"].get<std::string>(), Catch::Contains("1000 times too small"));
  CHECK_THAT(wrong["warnings"].dump(), Catch::Contains("does not fit the photographs"));
}

TEST_CASE("options of a diagnosis that cannot be are refused by name") {
  MeshDiagnosisOptions options;
  CHECK_NOTHROW(check(options));
  options.least_correlation = 1;
  CHECK_THROWS_WITH(check(options), "mesh diagnosis: least_correlation is 1, must be in (0, 1)");
  options = {};
  options.fit.views = 1;
  CHECK_THROWS_WITH(check(options), "mesh fit: views is 1, must be at least 2");
}

}  // namespace
}  // namespace lumatlas
