// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/synth.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "atlas/images/photograph.h"
#include "mesh/base/errors.h"
#include "mesh/readers/mesh_file.h"
#include "tests/support/scenes/synth_files.h"
#include "tests/support/temporary_folder.h"
#include "tools/lab/synth/kinds.h"
#include "tools/lab/synth/random.h"
#include "tools/lab/synth/tracer.h"
#include "tools/scene/forms/colmap/colmap_writer.h"
#include "tools/scene/scene.h"

namespace lumatlas {
namespace {

SynthOptions small_options() {
  SynthOptions options;
  options.views = 4;
  options.width = 48;
  options.height = 36;
  options.samples = 2;
  options.triangles = 20000;
  return options;
}

TEST_CASE("a synthetic scene has the same bytes for any number of threads, and others for another seed") {
  SynthOptions options = small_options();
  const auto one = written(options, 1);
  CHECK(one.size() == 4 + 3 + 1);
  CHECK(one.count("images/0003.png") == 1);
  CHECK((one == written(options, 4)));
  options.seed = 2;
  const auto other = written(options, 4);
  CHECK(one.at("images/0000.png") != other.at("images/0000.png"));
  CHECK(one.at("mesh.ply") != other.at("mesh.ply"));
}

TEST_CASE("a bad option of a synthetic scene is refused by name, with the value and the rule") {
  CHECK_NOTHROW(check(SynthOptions{}));
  SynthOptions options;
  options.views = 0;
  CHECK_THROWS_WITH(check(options), "synth: views is 0, must be in [1, 100000]");
  options = {};
  options.width = 8;
  CHECK_THROWS_WITH(check(options), "synth: width is 8, must be in [16, 8192]");
  options = {};
  options.height = 9000;
  CHECK_THROWS_WITH(check(options), "synth: height is 9000, must be in [16, 8192]");
  options = {};
  options.fov_deg = std::nan("");
  CHECK_THROWS_WITH(check(options), "synth: fov_deg is nan, must be in (0, 170]");
  options = {};
  options.samples = 2000;
  CHECK_THROWS_WITH(check(options), "synth: samples is 2000, must be in [1, 1024]");
  options = {};
  options.triangles = 0;
  CHECK_THROWS_WITH(check(options), "synth: triangles is 0, must be in [1, 20000000]");
  CHECK_THROWS_AS(write_synthetic_scene(options, "unused"), std::invalid_argument);
}

TEST_CASE("every kind of scene is found by its name, and another name is refused with those that there are") {
  for (const SynthKindRow& row : synth_kinds()) {
    CHECK(synth_kind_named(row.name) == row.kind);
    CHECK(&synth_kind(row.kind) == &row);
  }
  CHECK_THROWS_WITH(synth_kind_named("castle"), Catch::StartsWith("synth: kind is castle, must be one of apartment"));
}

TEST_CASE("a synthetic scene for a folder that does not exist is refused by path") {
  const TemporaryFolder folder;
  CHECK_THROWS_AS(write_synthetic_scene(small_options(), folder / "missing"), InputError);
  CHECK_THROWS_WITH(write_synthetic_scene(small_options(), folder / "missing"),
                    Catch::StartsWith((folder / "missing/images").string() + ": cannot be created: "));
}

// ---- The mesh.

glm::dvec3 corner(const Mesh& mesh, std::uint32_t vertex) {
  return glm::dvec3(mesh.positions[vertex]);
}

glm::dvec3 area_vector(const Mesh& mesh, const glm::uvec3& f) {
  return 0.5 * glm::cross(corner(mesh, f.y) - corner(mesh, f.x), corner(mesh, f.z) - corner(mesh, f.x));
}

TEST_CASE("a photograph hardly depends on how finely the mesh is cut") {
  const synth::Scene coarse = synth::make_apartment(1, 20000);
  const synth::Scene fine = synth::make_apartment(1, 100000);
  const Camera camera = synth::cameras_on_walk(coarse, small_options())[1];
  const Photograph a = synth::Tracer(coarse).photograph(camera, 4, 1);
  const Photograph b = synth::Tracer(fine).photograph(camera, 4, 1);
  std::size_t different = 0;  // a ray at a silhouette may go the other way by rounding
  for (std::size_t i = 0; i < a.rgb.size(); ++i) different += std::abs(a.rgb[i] - b.rgb[i]) > 2 ? 1 : 0;
  CHECK(static_cast<double>(different) < 0.01 * static_cast<double>(a.rgb.size()));
}

synth::Convex moved(synth::Convex body) {
  body.origin = {-1, 2, 0.5};
  body.yaw = 0.7;
  return body;
}

TEST_CASE("a convex body contains what is between its sides, where it stands") {
  const synth::Solid roof = moved(synth::gable_roof({3, 2}, 1.5, 0, synth::kOpen));
  const auto at = [](double along, double aside, double up) {
    return glm::dvec3(-1, 2, 0.5) + along * glm::dvec3(std::cos(0.7), std::sin(0.7), 0) +
           aside * glm::dvec3(-std::sin(0.7), std::cos(0.7), 0) + glm::dvec3(0, 0, up);
  };
  CHECK(synth::contains(roof, at(0, 0, 1.49)));
  CHECK(synth::contains(roof, at(1.49, 0.9, 0.1)));
  CHECK_FALSE(synth::contains(roof, at(0, 0, 1.51)));
  CHECK_FALSE(synth::contains(roof, at(0, 0.6, 0.7)));
  CHECK_FALSE(synth::contains(roof, at(1.51, 0, 0.1)));  // beyond a side without surface
  CHECK_FALSE(synth::contains(roof, at(0, 0, -0.01)));
}

TEST_CASE("the faces of solids are as many as counted, and close round the volume of a closed solid") {
  const double pi = std::acos(-1.0);
  const synth::Cylinder cylinder{{1, 2, 3}, 0.5, 2, 0, 0, 0};
  const synth::Sphere sphere{{1, 2, 3}, 0.5, 0};
  synth::Block block;
  block.origin = {4, 5, 6};
  block.yaw = 0.4;
  block.parts = {{{0, 0, 0}, {1, 1, 1}, {}}, {{1, 0.25, 0}, {2, 0.75, 0.5}, {}}};
  const std::vector<std::pair<synth::Solid, double>> volumes = {
      {cylinder, 2 * 0.25 * 24 * std::sin(2 * pi / 48)},
      {sphere, 4.0 / 3 * pi * 0.125},
      {block, 1.25},
      {moved(synth::gable_roof({3, 2}, 1.5, 0, 0)), 0.5 * 3 * 2 * 1.5},
      {moved(synth::frustum({6, 1, 0.5, 2}, 0, 0, 0)), 2 * 1.75 / 3 * 3 * std::sin(pi / 3)},
      {moved(synth::frustum({4, 1, 0, 1.5}, 0, 0, synth::kOpen)), 1.5 / 3 * 2}};
  for (const double edge : {10.0, 0.3, 0.05}) {
    for (const auto& [solid, volume] : volumes) {
      const std::vector<synth::Solid> solids{solid};
      const Mesh mesh = synth::tessellate(solids, edge).mesh;
      CHECK(static_cast<double>(mesh.faces.size()) == synth::count_faces(solids, edge));
      double sum = 0;  // divergence theorem
      for (const glm::uvec3& f : mesh.faces) {
        sum += glm::dot(corner(mesh, f.x) - glm::dvec3(1, 2, 3), area_vector(mesh, f)) / 3;
      }
      CHECK(sum == Approx(volume).epsilon(0.02));  // the sphere's faces lie inside the ball
    }
  }
}

TEST_CASE("on every side of a block s goes to the right and t goes up, as seen from the air") {
  for (const bool hollow : {false, true}) {
    synth::Block block;
    block.parts = {{{0, 0, 0}, {1, 2, 3}, {}}};
    block.hollow = hollow;
    const std::vector<synth::Solid> solids{block};
    const synth::Tessellation cut = synth::tessellate(solids, 10);
    REQUIRE(cut.surfaces.size() == 6);
    for (std::size_t i = 0; i < cut.mesh.faces.size(); ++i) {
      const synth::Surface& surface = cut.surfaces[cut.surface_of_face[i]];
      const glm::dvec3 out = glm::normalize(area_vector(cut.mesh, cut.mesh.faces[i]));
      CHECK(glm::dot(out, glm::dvec3(glm::cross(surface.u, surface.v))) == Approx(1));
      if (std::abs(out.z) < 0.5) CHECK(surface.v.z == Approx(1));
      for (int k = 0; k < 3; ++k) {
        const glm::vec2 st = synth::coordinates(surface, cut.mesh.positions[cut.mesh.faces[i][k]]);
        CHECK((std::abs(st.x) < 1e-5F || std::abs(st.x - surface.size.x) < 1e-5F));
        CHECK((std::abs(st.y) < 1e-5F || std::abs(st.y - surface.size.y) < 1e-5F));
      }
    }
  }
}

// ---- The cameras.

TEST_CASE("all cameras are valid, level, in the apartment's air and clear of its furniture") {
  SynthOptions options = small_options();
  options.views = 400;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const synth::Scene scene = synth::make_apartment(seed, 60000);
    const std::vector<Camera> cameras = synth::cameras_on_walk(scene, options);
    REQUIRE(cameras.size() == 400);
    double nearest = 1e9;
    for (const Camera& camera : cameras) {
      CHECK_NOTHROW(check(camera));
      const glm::dvec3 right = glm::transpose(camera.cam_from_world_rotation) * glm::dvec3(1, 0, 0);
      const glm::dvec3 down = glm::transpose(camera.cam_from_world_rotation) * glm::dvec3(0, 1, 0);
      CHECK(std::abs(right.z) < 1e-12);
      CHECK(down.z < -0.8);
      CHECK(synth::contains(scene.solids[0], camera.center()));
      for (std::size_t i = 1; i < scene.solids.size(); ++i)
        CHECK_FALSE(synth::contains(scene.solids[i], camera.center()));
      for (const glm::vec3& p : scene.geometry.mesh.positions) {
        nearest = std::min(nearest, glm::distance(glm::dvec3(p), camera.center()));
      }
    }
    CHECK(nearest > 0.25);
  }
}

TEST_CASE("the walk is a loop of equal steps") {
  SynthOptions options = small_options();
  options.views = 200;
  const std::vector<Camera> cameras = synth::cameras_on_walk(synth::make_apartment(1, 1), options);
  double shortest = 1e9;
  double longest = 0;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const double step = glm::distance(cameras[i].center(), cameras[(i + 1) % cameras.size()].center());
    shortest = std::min(shortest, step);
    longest = std::max(longest, step);
  }
  CHECK(longest < 1.05 * shortest);  // chords of a curve; the last step closes the loop
  CHECK(longest < 0.15);
}

TEST_CASE("the path's frames are equal small steps, in the open, and turn smoothly") {
  SynthOptions options = small_options();
  options.path_frames = 40;
  options.path_step = 0.03;
  const synth::Scene scene = synth::make_apartment(1, 20000);
  const synth::Tracer tracer(scene);
  const std::vector<Camera> frames = synth::cameras_on_path(scene, options);
  REQUIRE(frames.size() == 40);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    CHECK(glm::distance(frames[i].center(), frames[i - 1].center()) == Approx(0.03).epsilon(0.01));
    CHECK(glm::dot(frames[i].viewing_direction(), frames[i - 1].viewing_direction()) > 0.99);
    CHECK(tracer.sees(frames[i - 1].center(), frames[i].center()));
  }
  options.path_step = 0;
  CHECK_THROWS_WITH(check(options), "synth: path_step is 0, must be finite and above 0");
}

TEST_CASE("a synthetic scene with a path has its frames in a workspace of their own, undisturbed") {
  SynthOptions options = small_options();
  options.path_frames = 3;
  options.disturbances.exposure_noise = 1;
  options.disturbances.pose_noise = 2;
  const TemporaryFolder folder;
  write_synthetic_scene(options, folder.path());
  const SceneViews path = read_scene_views(folder / "path", glm::dvec3(0));
  REQUIRE(path.views.size() == 3);
  const synth::Scene scene = synth::make_apartment(options.seed, options.triangles);
  const std::vector<Camera> frames = synth::cameras_on_path(scene, options);
  const synth::Tracer tracer(scene);
  for (std::size_t frame = 0; frame < 3; ++frame) {
    CHECK(glm::distance(path.views[frame].camera.center(), frames[frame].center()) < 1e-9);
    CHECK(load_photograph(path.views[frame]).rgb ==
          tracer.photograph(frames[frame], 4 * options.samples, synth::hashed(options.seed, 3, frame)).rgb);
  }
}

TEST_CASE("a walk of three points is refused") {
  synth::Scene scene;
  scene.walk.resize(3);
  CHECK_THROWS_WITH(synth::cameras_on_walk(scene, small_options()), "scene: walk has 3 points, must have at least 4");
}

TEST_CASE("nearly all that a held-out view sees is seen by others") {
  const synth::Scene scene = synth::make_apartment(1, 12000);
  const std::vector<Camera> cameras = synth::cameras_on_walk(scene, SynthOptions{});
  const synth::Tracer tracer(scene);
  const auto sees = [&](const Camera& camera, const glm::dvec3& p) {
    const glm::dvec3 cam = camera.cam_from_world(p);
    const glm::dvec2 at = camera.image_from_cam(cam);
    return cam.z > 0 && at.x >= 0 && at.y >= 0 && at.x < camera.width && at.y < camera.height &&
           tracer.sees(camera.center(), p);
  };
  double held = 0;
  double known = 0;
  for (const glm::uvec3& f : scene.geometry.mesh.faces) {
    const glm::dvec3 middle =
        (corner(scene.geometry.mesh, f.x) + corner(scene.geometry.mesh, f.y) + corner(scene.geometry.mesh, f.z)) / 3.0;
    double weight = 0;  // solid angles of the face from the held-out views
    bool others = false;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      if (!sees(cameras[i], middle)) continue;
      const glm::dvec3 way = cameras[i].center() - middle;
      if (i % 8 == 0)
        weight += std::abs(glm::dot(area_vector(scene.geometry.mesh, f), way)) / std::pow(glm::length(way), 3);
      if (i % 8 != 0) others = true;
    }
    held += weight;
    if (others) known += weight;
  }
  CHECK(held > 0);
  CHECK(known > 0.93 * held);
}

// ---- The files.

// Reads numbers from the start of a file's bytes.
class Cursor {
 public:
  explicit Cursor(std::string bytes) : bytes_(std::move(bytes)) {}
  template <typename T>
  T next() {
    REQUIRE(at_ + sizeof(T) <= bytes_.size());
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  glm::dvec3 next_vector() {
    const auto x = next<double>();
    const auto y = next<double>();
    return {x, y, next<double>()};
  }
  std::string next_text() {
    std::string text = bytes_.c_str() + at_;
    at_ += text.size() + 1;
    return text;
  }
  [[nodiscard]] bool at_end() const { return at_ == bytes_.size(); }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

struct ReadImage {
  std::string name;
  glm::dmat3 rotation;
  glm::dvec3 translation;
  std::uint32_t camera;
  std::vector<std::pair<glm::dvec2, std::uint64_t>> keypoints;
};

std::map<std::uint32_t, ReadImage> read_images(const std::filesystem::path& path) {
  Cursor file(bytes_of(path));
  std::map<std::uint32_t, ReadImage> images;
  for (auto left = file.next<std::uint64_t>(); left > 0; --left) {
    ReadImage& image = images[file.next<std::uint32_t>()];
    const auto w = file.next<double>();
    const glm::dvec3 xyz = file.next_vector();
    image.rotation = glm::mat3_cast(glm::dquat(w, xyz.x, xyz.y, xyz.z));
    image.translation = file.next_vector();
    image.camera = file.next<std::uint32_t>();
    image.name = file.next_text();
    for (auto points = file.next<std::uint64_t>(); points > 0; --points) {
      const auto x = file.next<double>();
      const auto y = file.next<double>();
      image.keypoints.push_back({{x, y}, file.next<std::uint64_t>()});
    }
  }
  CHECK(file.at_end());
  return images;
}

TEST_CASE("the written COLMAP cameras and poses are the scene's cameras") {
  const TemporaryFolder folder;
  const SynthOptions options = small_options();
  write_synthetic_scene(options, folder.path());
  const std::vector<Camera> cameras =
      synth::cameras_on_walk(synth::make_apartment(options.seed, options.triangles), options);
  Cursor file(bytes_of(folder / "sparse/cameras.bin"));
  CHECK(file.next<std::uint64_t>() == 1);
  CHECK(file.next<std::uint32_t>() == 1);
  CHECK(file.next<std::int32_t>() == 1);  // PINHOLE
  CHECK(file.next<std::uint64_t>() == 48);
  CHECK(file.next<std::uint64_t>() == 36);
  for (const double expected : {cameras[0].fx, cameras[0].fy, cameras[0].cx, cameras[0].cy})
    CHECK(file.next<double>() == expected);
  CHECK(file.at_end());
  const auto images = read_images(folder / "sparse/images.bin");
  REQUIRE(images.size() == cameras.size());
  for (std::uint32_t i = 0; i < cameras.size(); ++i) {
    const ReadImage& image = images.at(i + 1);
    CHECK(image.name == "000" + std::to_string(i) + ".png");
    CHECK(image.camera == 1);
    CHECK(glm::length(image.translation - cameras[i].cam_from_world_translation) < 1e-12);
    for (int column = 0; column < 3; ++column) {
      CHECK(glm::length(image.rotation[column] - cameras[i].cam_from_world_rotation[column]) < 1e-12);
    }
  }
}

TEST_CASE("the written points lie where their tracks see them, and the tracks name each other") {
  const TemporaryFolder folder;
  SynthOptions options = small_options();
  options.views = 24;
  write_synthetic_scene(options, folder.path());
  const std::vector<Camera> cameras = synth::cameras_on_walk(synth::make_apartment(options.seed, 1), options);
  const auto images = read_images(folder / "sparse/images.bin");
  Cursor file(bytes_of(folder / "sparse/points3D.bin"));
  const auto count = file.next<std::uint64_t>();
  CHECK(count > 500);
  std::size_t observations = 0;
  for (std::uint64_t left = count; left > 0; --left) {
    const auto id = file.next<std::uint64_t>();
    const glm::dvec3 position = file.next_vector();
    for (int channel = 0; channel < 3; ++channel) file.next<std::uint8_t>();
    CHECK(file.next<double>() == 0);
    const auto length = file.next<std::uint64_t>();
    CHECK(length >= 2);
    for (std::uint64_t i = 0; i < length; ++i, ++observations) {
      const auto view = file.next<std::uint32_t>();
      const auto& [at, point] = images.at(view).keypoints.at(file.next<std::uint32_t>());
      CHECK(point == id);
      const Camera& camera = cameras[view - 1];
      CHECK(glm::length(camera.image_from_cam(camera.cam_from_world(position)) - at) < 1e-9);
    }
  }
  CHECK(file.at_end());
  for (const auto& [id, image] : images) observations -= image.keypoints.size();
  CHECK(observations == 0);
}

TEST_CASE("the written mesh and photographs are the scene's") {
  const TemporaryFolder folder;
  const SynthOptions options = small_options();
  std::atomic<int> done = 0;
  write_synthetic_scene(options, folder.path(), [&] { ++done; });
  CHECK(done == 4);
  const synth::Scene scene = synth::make_apartment(options.seed, options.triangles);
  const TriangleSoup soup = read_triangle_soup(folder / "mesh.ply");
  CHECK((soup.faces == scene.geometry.mesh.faces));
  REQUIRE(soup.positions.size() == scene.geometry.mesh.positions.size());
  for (std::size_t i = 0; i < soup.positions.size(); i += 97)
    CHECK((soup.positions[i] == glm::dvec3(scene.geometry.mesh.positions[i])));
  const Camera camera = synth::cameras_on_walk(scene, options)[2];
  const Photograph expected =
      synth::Tracer(scene).photograph(camera, options.samples, synth::hashed(options.seed, 2, 2));
  CHECK((read_photograph(folder / "images/0002.png").rgb == expected.rgb));
}

TEST_CASE("a written synthetic scene is read as its own cameras, mesh and photographs") {
  const TemporaryFolder folder;
  const SynthOptions options = small_options();
  write_synthetic_scene(options, folder.path());
  const synth::Scene scene = synth::make_apartment(options.seed, options.triangles);
  const std::vector<Camera> cameras = synth::cameras_on_walk(scene, options);
  const SceneViews read = read_scene_views(folder.path(), glm::dvec3(0.0));
  REQUIRE(read.views.size() == cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Camera& camera = read.views[i].camera;
    CHECK(camera.width == cameras[i].width);
    CHECK(camera.height == cameras[i].height);
    CHECK(camera.fx == cameras[i].fx);
    CHECK(camera.fy == cameras[i].fy);
    CHECK(camera.cx == cameras[i].cx);
    CHECK(camera.cy == cameras[i].cy);
    CHECK(glm::length(camera.center() - cameras[i].center()) < 1e-12);
    CHECK(glm::length(camera.viewing_direction() - cameras[i].viewing_direction()) < 1e-12);
    CHECK(load_photograph(read.views[i]).rgb.size() == 3 * 48 * 36);
  }
  CHECK(find_mesh(folder.path(), std::nullopt) == folder / "mesh.ply");
}

TEST_CASE("photographs with different lenses get a camera each, and a track to no image is refused") {
  const TemporaryFolder folder;
  Camera wide;
  wide.width = 40;
  wide.height = 30;
  wide.fx = wide.fy = 20;
  Camera narrow = wide;
  narrow.fx = 30;
  const std::vector<WrittenView> images{{"a.png", wide}, {"b/c.png", narrow}, {"d.png", wide}};
  write_colmap_model(folder.path(), images, {});
  const auto read = read_images(folder / "images.bin");
  CHECK(read.at(1).camera == 1);
  CHECK(read.at(2).camera == 2);
  CHECK(read.at(2).name == "b/c.png");
  CHECK(read.at(3).camera == 1);
  CHECK(Cursor(bytes_of(folder / "cameras.bin")).next<std::uint64_t>() == 2);
  const std::vector<TrackedPoint> points{{{1, 2, 3}, {}, {{3, {1, 1}}}}};
  CHECK_THROWS_WITH(write_colmap_model(folder.path(), images, points),
                    "point 0: its track names image 3, must be below 3");
  CHECK_THROWS_WITH(write_colmap_model(folder / "missing", images, {}),
                    (folder / "missing/cameras.bin").string() + ": cannot be written, its folder does not exist");
}

TEST_CASE("a stream has the photographs with their written poses, and the depths that a sensor measures") {
  SynthOptions options = small_options();
  options.stream_rate = 10;
  options.disturbances.pose_noise = 0.5;
  const TemporaryFolder folder;
  write_synthetic_scene(options, folder.path());
  const SceneViews workspace = read_scene_views(folder.path(), glm::dvec3(0));
  const SceneViews stream = read_scene_views(folder.path() / "stream", glm::dvec3(0));
  CHECK(stream.form == "TUM RGB-D");
  REQUIRE(stream.views.size() == options.views);
  REQUIRE(stream.depths.size() == options.views);
  for (std::size_t i = 0; i < stream.views.size(); ++i) {
    const Camera &expected = workspace.views[i].camera, &camera = stream.views[i].camera;
    CHECK(glm::distance(camera.center(), expected.center()) < 1e-6);
    CHECK(camera.fx == Approx(expected.fx));
    CHECK(camera.cx == Approx(expected.cx));
    CHECK(load_photograph(stream.views[i]).rgb == load_photograph(workspace.views[i]).rgb);
    const GreyImage depth = read_grey_image(stream.depths[i].file);
    CHECK(depth.width == options.width);
    const auto measured = std::count_if(depth.values.begin(), depth.values.end(), [](auto value) { return value > 0; });
    CHECK(static_cast<double>(measured) > 0.3 * options.width * options.height);
    // A structured-light sensor measures from 0.4 to 3.5 units, of 5000 steps.
    CHECK(std::all_of(depth.values.begin(), depth.values.end(),
                      [](auto value) { return value == 0 || (value >= 1990 && value <= 17510); }));
  }
  options.stream_rate = -1;
  CHECK_THROWS_WITH(check(options), Catch::Contains("stream_rate is -1"));
}

}  // namespace
}  // namespace lumatlas
