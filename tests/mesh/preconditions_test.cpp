// SPDX-License-Identifier: GPL-3.0-or-later
// The messages of the functions of mesh/ for callers who break their rules, one by one.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "mesh/cells/cell_growth.h"
#include "mesh/cells/cells.h"
#include "mesh/cells/split_faces.h"
#include "mesh/readers/mesh_file.h"
#include "mesh/repair/decimation.h"
#include "mesh/repair/joined_faces.h"
#include "mesh/scene_extent.h"
#include "mesh/visibility/ray_visibility.h"
#include "tests/support/scenes/surfaces.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

void refused(const std::function<void()>& call, const std::string& sentence) {
  CHECK_THROWS_MATCHES(call(), std::invalid_argument, Catch::Message(sentence));
}

struct Use {
  const char* name;
  std::function<void(const Mesh&)> of;
};

std::vector<Use> uses_of_any_coordinates() {
  return {{"bounds", [](const Mesh& mesh) { (void)bounds(mesh); }},
          {"joined_faces", [](const Mesh& mesh) { (void)joined_faces(mesh); }},
          {"match_faces before", [](const Mesh& mesh) { (void)match_faces(mesh, {}); }},
          {"match_faces", [](const Mesh& mesh) { (void)match_faces({}, mesh); }}};
}

std::vector<Use> uses() {
  static const TemporaryFolder folder;
  const std::vector<CellId> of_face(8, 0);
  const std::vector<FaceId> new_faces(8, FaceId::none);
  return {{"make_cells", [](const Mesh& mesh) { (void)make_cells(mesh, {}); }},
          {"make_cells of a grid",
           [](const Mesh& mesh) {
             (void)make_cells(mesh, {Partition::grid, 1, 2});
           }},
          {"measure_cells", [=](const Mesh& mesh) { (void)measure_cells(mesh, of_face, 1); }},
          {"split_large_faces", [](const Mesh& mesh) { (void)split_large_faces(mesh, 0.1); }},
          {"scene_extent", [](const Mesh& mesh) { (void)scene_extent(mesh); }},
          {"scene_diameter", [](const Mesh& mesh) { (void)scene_diameter(mesh); }},
          {"automatic_cell_size", [](const Mesh& mesh) { (void)automatic_cell_size(mesh); }},
          {"grow_cells", [=](const Mesh& mesh) { (void)grow_cells({}, {}, mesh, new_faces, {}); }},
          {"grow_cells before",
           [=](const Mesh& mesh) {
             const Cells cells = measure_cells(plane(2, 1), of_face, 1);
             (void)grow_cells(mesh, cells, plane(2, 1), new_faces, {});
           }},
          {"decimated", [](const Mesh& mesh) { (void)decimated(mesh, 4); }},
          {"make_ray_visibility", [](const Mesh& mesh) { (void)make_ray_visibility(mesh); }},
          {"write_ply", [](const Mesh& mesh) { write_ply(folder / "a.ply", mesh); }}};
}

TEST_CASE("a face that refers to no vertex is refused by every function that takes a mesh") {
  Mesh mesh = plane(2, 1);
  mesh.faces[5].y = 9;
  std::vector<Use> all = uses();
  for (Use& use : uses_of_any_coordinates()) all.push_back(use);
  for (const Use& use : all) {
    INFO(use.name);
    CHECK_NOTHROW(use.of(plane(2, 1)));
    refused([&] { use.of(mesh); }, "mesh.faces[5] refers to vertex 9; it must be below 9");
  }
}

TEST_CASE("colours for some of the vertices are refused") {
  Mesh mesh = plane(2, 1);
  mesh.colors.pop_back();
  for (const Use& use : uses()) {
    INFO(use.name);
    refused([&] { use.of(mesh); }, "mesh.colors has 8 entries; it must be empty or have one per position (9)");
  }
}

TEST_CASE("a position that is not finite is refused, the first one by its number") {
  Mesh mesh = plane(2, 1);
  mesh.positions[3].y = std::numeric_limits<float>::infinity();
  mesh.positions[7].z = std::nanf("");
  for (const Use& use : uses()) {
    INFO(use.name);
    refused([&] { use.of(mesh); }, "mesh.positions[3] is (0.000000, inf, 0.000000); it must be finite");
  }
  for (const Use& use : uses_of_any_coordinates()) CHECK_NOTHROW(use.of(mesh));
}

TEST_CASE("bounds of a soup need faces that refer to positions") {
  refused(
      [] {
        (void)bounds(TriangleSoup{{{0, 0, 0}}, {}, {{0, 0, 1}}});
      },
      "soup.faces[0] refers to vertex 1; it must be below 1");
}

TEST_CASE("cells are measured for a size that is one") {
  const std::vector<CellId> of_face(8, 0);
  refused([&] { (void)measure_cells(plane(2, 1), of_face, -1); }, "cells: size is -1, must be finite and not negative");
  refused([&] { (void)measure_cells(plane(2, 1), of_face, std::nan("")); },
          "cells: size is nan, must be finite and not negative");
}

TEST_CASE("pixels are counted of faces and cells that exist") {
  Cells cells = measure_cells(plane(2, 1), std::vector<CellId>(8, 0), 1);
  refused(
      [&] {
        (void)count_cell_pixels({1, 1, {1.0f}, {8}}, cells);
      },
      "visibility: the buffer shows face 8, must be below the number of faces in cells, 8");
  cells.cell_of_face[2] = 1;
  refused(
      [&] {
        (void)count_cell_pixels({1, 1, {1.0f}, {2}}, cells);
      },
      "cells: cell_of_face[2] is 1, must be below the number of cells, 1");
}

TEST_CASE("a camera is scaled from some pixels to some") {
  Camera camera;
  refused([&] { (void)camera.scaled_to(2, 2); }, "camera: width is 0, must be above 0");
  refused([&] { (void)camera.shrunk_to(2); }, "camera: width is 0, must be above 0");
  camera.width = 4;
  refused([&] { (void)camera.scaled_to(2, 2); }, "camera: height is 0, must be above 0");
  refused([&] { (void)camera.shrunk_to(2); }, "camera: height is 0, must be above 0");
  camera.height = 3;
  refused([&] { (void)camera.scaled_to(0, 2); }, "camera: the new width is 0, must be above 0");
  refused([&] { (void)camera.scaled_to(2, 0); }, "camera: the new height is 0, must be above 0");
  refused([&] { (void)camera.shrunk_to(0); }, "camera: the new longer side is 0, must be above 0");
  CHECK_NOTHROW(camera.shrunk_to(1));
}

}  // namespace
}  // namespace lumatlas
