// SPDX-License-Identifier: GPL-3.0-or-later
// From a mesh file to a surface: its frame, and what is said of its colours.
#include "tools/surface/surface_input.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "mesh/readers/mesh_file.h"
#include "tests/support/colmap_bytes.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

using test::write_file;

TEST_CASE("a mesh file is moved before it becomes floats") {
  const TemporaryFolder folder;
  TriangleSoup soup{{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, {}, {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}}};
  for (glm::dvec3& position : soup.positions) position += glm::dvec3(500000.03125, 4500000.0625, 0);
  {
    std::ofstream file(folder / "mesh.ply", std::ios::binary);
    write_ply(file, soup);
  }
  const MeshInput moved = load_mesh(folder.path(), std::nullopt, 0, {.shift = {-500000, -4500000, 0}});
  CHECK(moved.offset == glm::dvec3(0.53125, 1.0625, 1.5));
  CHECK(moved.mesh.positions.front() == glm::vec3(-0.5f, -1, -1.5f));
  CHECK(moved.facts.frame.shift.y == -4500000);
  CHECK_THROWS_AS(load_mesh(folder.path(), std::nullopt, 0, {.scale = -1}), std::invalid_argument);
}

TEST_CASE("colours of a PLY mesh under names that are not read are told, and those that are read are not") {
  const TemporaryFolder folder;
  const auto warnings = [&](const std::string& prefix) {
    std::string ply = "ply\nformat ascii 1.0\nelement vertex 3\n";
    for (const std::string name : {"x", "y", "z"}) ply += "property float " + name + "\n";
    for (const std::string name : {"red", "green", "blue"}) ply += "property uchar " + prefix + name + "\n";
    ply += "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    ply += "0 0 0 1 2 3\n1 0 0 1 2 3\n0 1 0 1 2 3\n3 0 1 2\n";
    write_file(folder / "mesh.ply", ply);
    return load_mesh(folder.path(), std::nullopt).facts.warnings;
  };
  CHECK(warnings("").empty());
  CHECK(warnings("diffuse_").empty());
  CHECK(warnings("ambient_") ==
        std::vector{(folder / "mesh.ply").string() +
                    ": its vertices have colours that are not read, named ambient_red, ambient_green, ambient_blue: "
                    "name them red, green and blue"});
}

}  // namespace
}  // namespace lumatlas
