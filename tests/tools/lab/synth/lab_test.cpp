// SPDX-License-Identifier: GPL-3.0-or-later
// The laboratory, and how a depth sensor scans it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mesh/readers/mesh_file.h"
#include "tests/support/scenes/surfaces.h"
#include "tests/support/scenes/synth_files.h"
#include "tests/support/temporary_folder.h"
#include "tools/lab/synth/scan.h"
#include "tools/lab/synth/synth.h"
#include "tools/lab/synth/tracer.h"

namespace lumatlas::synth {
namespace {

SynthOptions lab_options() {
  SynthOptions options;
  options.kind = SynthKind::lab;
  options.views = 12;
  options.width = 48;
  options.height = 36;
  options.samples = 2;
  options.triangles = 20000;
  return options;
}

double distance_to_face(const Mesh& mesh, const glm::uvec3& f, const glm::dvec3& p) {
  const glm::dvec3 a(mesh.positions[f.x]);
  const glm::dvec3 b(mesh.positions[f.y]);
  const glm::dvec3 c(mesh.positions[f.z]);
  const auto to_edge = [&](const glm::dvec3& from, const glm::dvec3& to) {
    const double share = glm::clamp(glm::dot(p - from, to - from) / glm::dot(to - from, to - from), 0.0, 1.0);
    return glm::distance(p, glm::mix(from, to, share));
  };
  const glm::dvec3 n = glm::cross(b - a, c - a);
  const bool above = glm::dot(glm::cross(b - a, p - a), n) >= 0 && glm::dot(glm::cross(c - b, p - b), n) >= 0 &&
                     glm::dot(glm::cross(a - c, p - c), n) >= 0;
  if (above) return std::abs(glm::dot(p - a, n)) / glm::length(n);
  return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

double distance_to(const Mesh& mesh, const glm::dvec3& p) {
  double least = 1e9;
  for (const glm::uvec3& f : mesh.faces) {
    const glm::dvec3 a(mesh.positions[f.x]);  // the whole face is farther than its corner less its longest edge
    const double reach =
        std::max(glm::distance(a, glm::dvec3(mesh.positions[f.y])), glm::distance(a, glm::dvec3(mesh.positions[f.z])));
    if (glm::distance(a, p) - reach < least) least = std::min(least, distance_to_face(mesh, f, p));
  }
  return least;
}

// ---- The room.

TEST_CASE("the laboratory's true mesh is manifold and its walk is clear of what stands there") {
  SynthOptions options = lab_options();
  options.views = 200;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Scene scene = make_lab(seed, 60000);
    const Mesh& mesh = scene.geometry.mesh;
    CHECK(is_manifold_and_oriented(mesh));
    CHECK(static_cast<double>(mesh.faces.size()) == Approx(60000).epsilon(0.1));
    double nearest = 1e9;
    for (const Camera& camera : cameras_on_walk(scene, options)) {
      CHECK(contains(scene.solids[0], camera.center()));
      for (std::size_t i = 1; i < scene.solids.size(); ++i) CHECK_FALSE(contains(scene.solids[i], camera.center()));
      for (const glm::vec3& p : mesh.positions) {
        nearest = std::min(nearest, glm::distance(glm::dvec3(p), camera.center()));
      }
    }
    CHECK(nearest > 0.2);
  }
}

TEST_CASE("laboratory and apartment have a mirror without roughness") {
  for (const Scene& scene : {make_lab(1, 1000), make_apartment(1, 1000)}) {
    CHECK(std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& material) {
      return material.metal && material.roughness == 0 && material.colors[0].x > 0.85F;
    }));
  }
}

// ---- The sensor.

// A hollow cube of side 8 round the origin.
Scene cube(const Material& material) {
  Scene scene;
  scene.materials = {material};
  Block room;
  room.parts = {{{-4, -4, -4}, {4, 4, 4}, {}}};
  room.hollow = true;
  scene.solids.emplace_back(room);
  scene.geometry = tessellate(scene.solids, 10);
  return scene;
}

// Looks along x at the wall at x = 4, from this far.
Camera sensor(double distance, double turn = 0) {
  Camera camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = 290;
  camera.cx = 160;
  camera.cy = 120;
  const glm::dvec3 forward(std::cos(turn), std::sin(turn), 0);
  const glm::dvec3 right(std::sin(turn), -std::cos(turn), 0);
  camera.cam_from_world_rotation = glm::transpose(glm::dmat3(right, glm::dvec3(0, 0, -1), forward));
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * glm::dvec3(4 - distance, 0, 0));
  return camera;
}

Material reflecting(float reflectance) {
  Material material;
  material.colors[0] = glm::vec3(reflectance);
  return material;
}

double measured_share(const Scene& scene, const Camera& camera) {
  const Tracer tracer(scene);
  const DepthImage image = depth_image(tracer, camera, 1);
  const auto lost = static_cast<double>(std::count(image.depth.begin(), image.depth.end(), 0.0F));
  return 1 - lost / static_cast<double>(image.depth.size());
}

TEST_CASE("the sensor's depths have the noise of their distance, which neighbouring pixels share") {
  const Scene scene = cube(reflecting(0.6F));
  const Tracer tracer(scene);
  double before = 0;
  for (const double distance : {0.8, 1.6, 3.0}) {
    const DepthImage image = depth_image(tracer, sensor(distance), 7);
    double sum = 0;
    double squares = 0;
    double products = 0;  // of neighbours
    for (std::size_t i = 0; i + 1 < image.depth.size(); ++i) {
      const double error = image.depth[i] - distance;
      sum += error;
      squares += error * error;
      products += error * (image.depth[i + 1] - distance);
    }
    const auto count = static_cast<double>(image.depth.size());
    const double deviation = std::sqrt(squares / count);
    CHECK(deviation == Approx(axial_noise(distance)).epsilon(0.05));  // some 3800 windows: 1.1 % standard error
    CHECK(std::abs(sum / count) < 0.1 * deviation);
    CHECK(products / squares > 0.4);
    CHECK(deviation > 1.2 * before);
    before = deviation;
  }
  CHECK(depth_image(tracer, sensor(1.6), 7).depth == depth_image(tracer, sensor(1.6), 7).depth);
  CHECK(depth_image(tracer, sensor(1.6), 7).depth != depth_image(tracer, sensor(1.6), 8).depth);
}

TEST_CASE("the sensor measures nothing too near, too far, aslant, in the dark, and off metal, gloss and lamps") {
  const Scene grey = cube(reflecting(0.6F));
  CHECK(measured_share(grey, sensor(2)) == 1);
  CHECK(measured_share(grey, sensor(0.35)) == 0);
  CHECK(measured_share(grey, sensor(3.6)) < 0.01);                      // noise brings a few within reach
  CHECK(measured_share(grey, sensor(0.5, glm::radians(88.0))) < 0.75);  // one half is beyond 75 degrees
  CHECK(measured_share(cube(reflecting(0.03F)), sensor(1.2)) > 0.9);
  CHECK(measured_share(cube(reflecting(0.03F)), sensor(3)) == 0);
  Material metal = reflecting(0.9F);
  metal.metal = true;
  CHECK(measured_share(cube(metal), sensor(1.5)) == 0);
  Material lamp = reflecting(0.9F);
  lamp.emission = 1;
  CHECK(measured_share(cube(lamp), sensor(1.5)) == 0);
  Material glossy = reflecting(0.08F);
  CHECK(measured_share(cube(glossy), sensor(2.8)) > 0.9);
  glossy.gloss = 0.7F;
  CHECK(measured_share(cube(glossy), sensor(2.8)) == 0);
}

TEST_CASE("at edges the sensor sees now what is before and now what is behind") {
  Scene scene = cube(reflecting(0.6F));
  Block post;
  post.parts = {{{2.5, 0, -4}, {2.6, 4, 4}, {}}};
  scene.solids.emplace_back(post);
  scene.geometry = tessellate(scene.solids, 10);
  const Tracer tracer(scene);
  const DepthImage image = depth_image(tracer, sensor(3), 1);  // the edge is in the middle of the picture
  double near_left = 0;
  double near_right = 0;
  for (std::uint32_t y = 0; y < 240; ++y) {
    if (image.depth[std::size_t{y} * 320 + 159] < 2.2F) near_left += 1;
    if (image.depth[std::size_t{y} * 320 + 160] < 2.2F) near_right += 1;
  }
  // Half a pixel off the edge, at a lateral noise of 0.4 pixels: one in nine goes the other way.
  CHECK(near_left / 240 == Approx(0.89).margin(0.08));
  CHECK(near_right / 240 == Approx(0.11).margin(0.08));
}

// ---- The scan.

struct ScannedLab {
  SynthOptions options = lab_options();
  Scene scene = make_lab(options.seed, options.triangles);
  Tracer tracer{scene};
  Mesh scan = scanned(scene, tracer, options);
};

const ScannedLab& scanned_lab() {
  static const ScannedLab lab;
  return lab;
}

TEST_CASE("the scan is a manifold mesh of the triangles asked for, as far off the true surface as its sensor") {
  const ScannedLab& lab = scanned_lab();
  CHECK(is_manifold_and_oriented(lab.scan));
  CHECK(lab.scan.faces.size() <= lab.options.triangles);
  CHECK(lab.scan.faces.size() + 2 > lab.options.triangles);
  double squares = 0;
  double count = 0;
  double far = 0;
  for (std::size_t i = 0; i < lab.scan.positions.size(); i += 17) {
    const double distance = distance_to(lab.scene.geometry.mesh, glm::dvec3(lab.scan.positions[i]));
    squares += distance * distance;
    count += 1;
    if (distance > 0.1) far += 1;
  }
  const double rms = std::sqrt(squares / count);
  // Averaging takes away part of the sensor's noise at a typical 2 units, the voxels' size, 6 cm here, adds to it.
  CHECK(rms > 0.5 * axial_noise(2));
  CHECK(rms < 4 * axial_noise(2));
  CHECK(far / count < 0.02);
}

TEST_CASE("some of what the cameras see was not scanned") {
  const ScannedLab& lab = scanned_lab();
  double seen = 0;
  double missing = 0;
  for (const Camera& camera : cameras_on_walk(lab.scene, lab.options)) {
    for (double y = 3; y < camera.height; y += 6) {
      for (double x = 3; x < camera.width; x += 6) {
        const auto point = lab.tracer.surface_at(camera, {x, y});
        REQUIRE(point);
        seen += 1;
        if (distance_to(lab.scan, *point) > 0.06) missing += 1;
      }
    }
  }
  CHECK(missing / seen > 0.02);
  CHECK(missing / seen < 0.3);
}

TEST_CASE("a laboratory has the same bytes for any number of threads, its scan as mesh and the true one beside") {
  SynthOptions options = lab_options();
  options.views = 2;
  options.triangles = 3000;
  const auto one = written(options, 1);
  CHECK((one == written(options, 2)));
  CHECK(nlohmann::json::parse(one.at("truth/disturbances.json")).at("mesh").at("scanned") == true);
  CHECK(one.at("mesh.ply") != one.at("truth/mesh.ply"));
  const TemporaryFolder folder;
  const std::filesystem::path truth = folder / "truth.ply";
  write_ply(truth, make_lab(options.seed, options.triangles).geometry.mesh);
  CHECK((bytes_of(truth) == one.at("truth/mesh.ply")));
  options.seed = 2;
  CHECK(written(options, 2).at("mesh.ply") != one.at("mesh.ply"));
}

}  // namespace
}  // namespace lumatlas::synth
