// SPDX-License-Identifier: GPL-3.0-or-later
// A surface with a far sphere: its parts, what asks for one of them, and its place in a model file.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "atlas/model/gltf/gltf_mesh.h"
#include "atlas/model/model_file.h"
#include "atlas/snapshot.h"
#include "atlas/surface.h"
#include "mesh/base/errors.h"
#include "tests/support/scenes/far_scenes.h"
#include "tests/support/scenes/plain_model.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

using nlohmann::json;

void check_same(const Mesh& a, const Mesh& b) {
  CHECK(a.positions == b.positions);
  CHECK(a.colors == b.colors);
  CHECK(a.faces == b.faces);
}

TEST_CASE("a surface and its far sphere come apart as they were put together") {
  const auto near = wall_and_panel(5);
  const auto both = with_sphere_behind(*near);
  CHECK_NOTHROW(check(*both));
  CHECK(both->near_faces() == near->mesh.faces.size());
  CHECK(both->near_cells() == 5);
  CHECK(both->far_cells > 3);
  const Surface again = near_surface(*both);
  check_same(again.mesh, near->mesh);
  CHECK(again.cells.cell_of_face == near->cells.cell_of_face);
  CHECK(again.far_faces == 0);
  const FarSphere far = far_sphere_of(*both);
  check_same(far.mesh, far_sphere({{0, 0, 0}, 400}, 0.3));
  CHECK(far.cells.cells.size() == both->far_cells);
  // A second sphere takes the first one's place.
  CHECK(with_far_sphere(*both, far).mesh.faces.size() == both->mesh.faces.size());
  CHECK(far_sphere_of(*near).mesh.faces.empty());
}

TEST_CASE("a face, vertex or cell that is both near and far is refused") {
  Surface broken = *with_sphere_behind(*wall_and_panel(5));
  SECTION("a face with corners of both") {
    broken.mesh.faces.back().x = 0;
    CHECK_THROWS_WITH(check(broken), Catch::EndsWith("is both near and far"));
  }
  SECTION("a cell of both") {
    broken.cells.cell_of_face.front() = CellId(static_cast<std::uint32_t>(broken.near_cells()));
    CHECK_THROWS_WITH(check(broken), "surface: face 0 is both near and far");
  }
  SECTION("more far faces than there are") {
    broken.far_faces = static_cast<std::uint32_t>(broken.mesh.faces.size() + 1);
    CHECK_THROWS_WITH(check(broken), Catch::StartsWith("surface: far_faces is "));
  }
}

TEST_CASE("depths of the far sphere are told from those of the mesh") {
  const auto near = wall_and_panel(5);
  CHECK(std::isinf(depth_before_far(*near)));
  const auto both = with_sphere_behind(*near);
  VisibilityBuffer visible = make_ray_visibility(both->mesh)->trace(forward_camera(40, 30, {0, 0, -4}));
  const auto first_far = static_cast<std::uint32_t>(both->near_faces());
  std::size_t far = 0;
  for (std::size_t pixel = 0; pixel < visible.face.size(); ++pixel) {
    REQUIRE(visible.face[pixel] != FaceId::none);
    CHECK((visible.depth[pixel] > depth_before_far(*both)) == (visible.face[pixel] >= first_far));
    far += visible.face[pixel] >= first_far ? 1 : 0;
  }
  CHECK(far > 100);
  leave_out_far(*both, visible);
  const VisibilityBuffer without = make_ray_visibility(near->mesh)->trace(forward_camera(40, 30, {0, 0, -4}));
  CHECK(visible.face == without.face);
  CHECK(visible.depth == without.depth);
}

TEST_CASE("a snapshot without its far sphere is that of the mesh alone") {
  Snapshot both = far_snapshot();
  both.cell_deviation.assign(both.cell_seen.size(), 0.5f);
  const Snapshot near = without_far_sphere(both);
  CHECK_NOTHROW(check(near));
  CHECK(near.surface->cells.cells.size() == 5);
  CHECK(near.cell_deviation.size() == 5);
  CHECK(near.references.offsets.size() == 6);
  CHECK(near.references.views.size() == 10);
  CHECK(near.vertex_colors.size() == near.surface->mesh.positions.size());
  CHECK(std::equal(near.vertex_colors.get().begin(), near.vertex_colors.get().end(), both.vertex_colors.get().begin()));
  CHECK(near.views == both.views);
}

// The text of a model folder's glTF file.
json scene_of(const std::filesystem::path& model) {
  return json::parse(bytes_of(model / "scene.gltf"));
}

TEST_CASE("a model file holds the far sphere where other programs do not show it") {
  const TemporaryFolder folder;
  const Snapshot written = far_snapshot();
  write_model(folder.path(), written, ValidityOptions{});
  const Snapshot read = read_model(folder.path()).snapshot;
  CHECK(read.surface->far_cells == written.surface->far_cells);
  CHECK(read.surface->far_faces == written.surface->far_faces);
  CHECK(read.surface->near_faces() == written.surface->near_faces());
  CHECK(read.cell_seen == written.cell_seen);
  CHECK(read.references.offsets == written.references.offsets);
  CHECK(read.references.views == written.references.views);
  REQUIRE(read.views.size() == written.views.size());
  for (std::size_t slot = 0; slot < read.views.size(); ++slot) {
    CHECK(read.views[slot]->mask->depth == written.views[slot]->mask->depth);
    CHECK(read.views[slot]->mask->validity == written.views[slot]->mask->validity);
  }
  make_one_gltf(folder.path());
  const json scene = scene_of(folder.path());
  CHECK(scene["meshes"].size() == 2);
  for (const json& node : scene["nodes"]) CHECK(node.value("mesh", 0) == 0);
  const TriangleSoup shown = read_gltf_mesh(folder / "scene.gltf");
  CHECK(shown.faces.size() == written.surface->near_faces());
}

TEST_CASE("a model file whose far sphere is damaged is refused in one sentence") {
  const TemporaryFolder folder;
  write_model(folder.path(), far_snapshot(), ValidityOptions{});
  make_one_gltf(folder.path());
  json scene = scene_of(folder.path());
  const std::string path = (folder / "scene.gltf").string() + ": ";
  json& far = scene["extensions"]["LUMATLAS_lumigraph"]["far"];
  std::string expected;
  SECTION("another number of cells") {
    far["cells"] = far["cells"].get<int>() - 1;
    expected = "has no faces";
  }
  SECTION("more cells than there are") {
    far["cells"] = 1'000'000;
    expected = "must be in [1, ";
  }
  SECTION("no such mesh") {
    far["mesh"] = 7;
    expected = "holds no mesh 7";
  }
  SECTION("not an object") {
    far = 3;
    expected = "far is not an object";
  }
  std::ofstream(folder / "scene.gltf") << scene.dump();
  CHECK_THROWS_AS(read_model(folder / "scene.gltf"), InputError);
  CHECK_THROWS_WITH(read_model(folder / "scene.gltf"), Catch::StartsWith(path) && Catch::Contains(expected));
}

}  // namespace
}  // namespace lumatlas
