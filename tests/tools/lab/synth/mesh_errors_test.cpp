// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/errors/mesh_errors.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <set>
#include <vector>

#include "mesh/readers/mesh_file.h"
#include "tests/support/scenes/surfaces.h"
#include "tests/support/temporary_folder.h"
#include "tools/lab/synth/synth.h"

namespace lumatlas::synth {
namespace {

TEST_CASE("noise of the mesh has the stated root mean square along the normal, both ways, and leaves the faces alone") {
  const Mesh ball = sphere(5);
  for (const double rms : {0.0005, 0.01}) {
    const Mesh noisy = with_mesh_noise(ball, rms, 3);
    CHECK((noisy.faces == ball.faces));
    double sum = 0;
    double squares = 0;
    for (std::size_t i = 0; i < ball.positions.size(); ++i) {
      const glm::dvec3 moved = glm::dvec3(noisy.positions[i]) - glm::dvec3(ball.positions[i]);
      const double along = glm::dot(moved, glm::dvec3(ball.positions[i]));
      CHECK(glm::length(moved - along * glm::dvec3(ball.positions[i])) < 0.05 * rms + 1e-6);  // the faces' own normals
      sum += along;
      squares += along * along;
    }
    const auto count = static_cast<double>(ball.positions.size());
    CHECK(std::sqrt(squares / count) == Approx(rms).epsilon(0.04));  // 4098 vertices: 1.1 % standard error
    CHECK(std::abs(sum / count) < 0.05 * rms);
  }
  CHECK((with_mesh_noise(ball, 0.01, 3).positions == with_mesh_noise(ball, 0.01, 3).positions));
  CHECK((with_mesh_noise(ball, 0.01, 3).positions != with_mesh_noise(ball, 0.01, 4).positions));
}

TEST_CASE("holes take the share of the area that was asked for and leave a manifold mesh") {
  const Scene apartment = make_apartment(1, 30000);
  for (const Mesh& mesh : {sphere(5), plane(60, 3), apartment.geometry.mesh}) {
    for (const double share : {0.01, 0.1, 0.6}) {
      const Mesh rest = with_holes(mesh, share, 5);
      CHECK(1 - area_of(rest) / area_of(mesh) == Approx(share).epsilon(0.05));
      CHECK(is_manifold_and_oriented(rest));
      CHECK(area_of(with_holes(mesh, share, 6)) == Approx(area_of(rest)).epsilon(0.01));
      CHECK((with_holes(mesh, share, 6).positions != rest.positions));
    }
  }
}

TEST_CASE("a hole is a round patch") {
  const Mesh mesh = plane(200, 1);
  // The least radius is 1 % of the diagonal: half of a patch of 1.41 % of the side.
  const double share = 0.5 * std::numbers::pi * 2e-4;
  const Mesh rest = with_holes(mesh, share, 1);
  std::set<std::pair<float, float>> left;
  for (const glm::vec3& p : rest.positions) left.emplace(p.x, p.y);
  std::vector<glm::vec3> gone;  // corners within the hole
  glm::vec3 middle(0.0F);
  for (const glm::vec3& p : mesh.positions) {
    if (left.count({p.x, p.y}) > 0) continue;
    gone.push_back(p);
    middle += p;
  }
  REQUIRE(gone.size() > 5);
  middle /= static_cast<float>(gone.size());
  float radius = 0;
  for (const glm::vec3& p : gone) radius = std::max(radius, glm::distance(p, middle));
  CHECK(radius < 1.2 * std::sqrt(share / std::numbers::pi));
}

TEST_CASE("of an apartment's mesh, edge collapses leave the share of faces asked for") {
  SynthOptions options;
  const Mesh mesh = make_apartment(1, 20000).geometry.mesh;
  for (const double share : {0.7, 0.3}) {
    options.disturbances.decimate = share;
    const Mesh fewer = with_mesh_errors(mesh, options);
    CHECK(static_cast<double>(fewer.faces.size()) / static_cast<double>(mesh.faces.size()) ==
          Approx(share).epsilon(0.05));
    CHECK(is_manifold_and_oriented(fewer));
    CHECK(area_of(fewer) == Approx(area_of(mesh)).epsilon(0.01));
  }
}

TEST_CASE("a scene whose mesh is disturbed has the true one beside it, and the photographs of the true one") {
  SynthOptions options;
  options.views = 2;
  options.width = 32;
  options.height = 24;
  options.samples = 2;
  options.triangles = 8000;
  const TemporaryFolder plain;
  const TemporaryFolder disturbed;
  write_synthetic_scene(options, plain.path());
  options.disturbances.mesh_noise = 0.01;
  options.disturbances.holes = 0.1;
  options.disturbances.decimate = 0.5;
  write_synthetic_scene(options, disturbed.path());
  CHECK(bytes_of(disturbed / "truth/mesh.ply") == bytes_of(plain / "mesh.ply"));
  CHECK(bytes_of(disturbed / "images/0001.png") == bytes_of(plain / "images/0001.png"));
  CHECK(bytes_of(disturbed / "sparse/points3D.bin") == bytes_of(plain / "sparse/points3D.bin"));
  const TriangleSoup soup = read_triangle_soup(disturbed / "mesh.ply");
  const Mesh expected = with_mesh_errors(make_apartment(options.seed, options.triangles).geometry.mesh, options);
  CHECK((soup.faces == expected.faces));
  CHECK_FALSE(std::filesystem::exists(plain / "truth"));
}

}  // namespace
}  // namespace lumatlas::synth
