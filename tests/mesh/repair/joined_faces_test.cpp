// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/joined_faces.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <limits>
#include <random>

#include "tests/support/scenes/surfaces.h"

namespace lumatlas {
namespace {

TEST_CASE("faces that were cut apart meet again, others stay as they are") {
  const Mesh whole = plane(6, 2);
  CHECK(joined_faces(whole) == whole.faces);
  Mesh soup;  // each face with vertices of its own, the last face's first
  for (const glm::uvec3& face : whole.faces) {
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    for (int corner = 0; corner < 3; ++corner) soup.positions.push_back(whole.positions[face[corner]]);
    soup.faces.emplace_back(first, first + 1, first + 2);
  }
  const std::vector<glm::uvec3> joined = joined_faces(soup);
  REQUIRE(joined.size() == whole.faces.size());
  for (std::size_t a = 0; a < joined.size(); ++a) {
    for (std::size_t b = 0; b < joined.size(); ++b) {
      for (int i = 0; i < 9; ++i) {
        REQUIRE((joined[a][i / 3] == joined[b][i % 3]) == (whole.faces[a][i / 3] == whole.faces[b][i % 3]));
      }
    }
  }
  soup.positions[0].x += 1e-6f;  // another place
  CHECK(joined_faces(soup)[0].x == 0);
}

TEST_CASE("each vertex is replaced by the first at its place, of zeros of either sign, and of no numbers by itself") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> coordinates{
      0.0f, -0.0f, 1.0f, 1.0f + std::numeric_limits<float>::epsilon(), std::numeric_limits<float>::infinity(), nan};
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    const auto any = [&] { return coordinates[random() % coordinates.size()]; };
    Mesh mesh;
    for (int i = 0; i < 400; ++i) mesh.positions.emplace_back(any(), any(), any());
    for (int i = 0; i < 900; ++i) mesh.faces.emplace_back(random() % 400, random() % 400, random() % 400);
    const std::vector<glm::uvec3> joined = joined_faces(mesh);
    REQUIRE(joined.size() == mesh.faces.size());
    for (std::size_t face = 0; face < joined.size(); ++face) {
      for (int corner = 0; corner < 3; ++corner) {
        const std::uint32_t vertex = mesh.faces[face][corner];
        std::uint32_t first = 0;
        while (first < vertex && mesh.positions[first] != mesh.positions[vertex]) ++first;
        REQUIRE(joined[face][corner] == first);
      }
    }
  }
}

TEST_CASE("vertices that are no numbers take no longer than others") {
  Mesh mesh;
  mesh.positions.assign(1'000'000, glm::vec3(std::numeric_limits<float>::quiet_NaN()));
  mesh.faces = {{0, 1, 999'999}};
  CHECK(joined_faces(mesh) == mesh.faces);
  mesh.positions.assign(1'000'000, glm::vec3(std::numeric_limits<float>::infinity()));
  CHECK(joined_faces(mesh)[0] == glm::uvec3(0));
  CHECK(joined_faces({}).empty());
}

}  // namespace
}  // namespace lumatlas
