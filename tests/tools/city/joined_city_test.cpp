// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "mesh/base/errors.h"
#include "tests/tools/city/small_city.h"
#include "tools/city/block_job.h"
#include "tools/city/join_blocks.h"
#include "tools/pipeline/build_model.h"

namespace lumatlas {

namespace {

BuildResult built_in_one_piece() {
  BuildOptions options = small_city_options(1).build;
  options.texture_px.reset();
  return build_model(small_city_scene(), options);
}

using Corner = std::array<float, 3>;
using FacePlace = std::array<Corner, 3>;

FacePlace place_of(const Surface& surface, std::size_t face) {
  FacePlace place;
  for (int corner = 0; corner < 3; ++corner) {
    const glm::vec3& p = surface.mesh.positions[surface.mesh.faces[face][corner]];
    place.at(static_cast<std::size_t>(corner)) = {p.x, p.y, p.z};
  }
  return place;
}

std::set<std::string> views_of_cell(const Snapshot& snapshot, CellId cell) {
  std::set<std::string> names;
  for (const ViewSlot slot : snapshot.references.of_cell(cell)) names.insert(snapshot.views[slot]->name);
  return names;
}

// Returns the photographs that each near face refers to, by where the face is.
std::map<FacePlace, std::set<std::string>> references_by_face(const Snapshot& snapshot) {
  std::map<FacePlace, std::set<std::string>> references;
  const Surface& surface = *snapshot.surface;
  for (std::size_t face = 0; face < surface.near_faces(); ++face) {
    references[place_of(surface, face)] = views_of_cell(snapshot, surface.cells.cell_of_face[face]);
  }
  return references;
}

}  // namespace

TEST_CASE("A city of one block refers to the photographs that build refers to", "[joined_city]") {
  const BuildResult whole = built_in_one_piece();
  const SmallCity city(1'000'000);
  REQUIRE(city.plan.blocks.size() == 2);  // and the far sphere
  build_blocks(city.folder.path(), city.plan);
  const JoinedCity joined = join_blocks(city.folder.path(), city.plan, {});
  check(joined.snapshot);
  REQUIRE(joined.snapshot.georeference);
  CHECK(joined.snapshot.georeference == city.plan.georeference);
  CHECK(joined.snapshot.surface->far_cells == whole.snapshot.surface->far_cells);
  CHECK(joined.snapshot.surface->mesh.faces.size() == whole.snapshot.surface->mesh.faces.size());
  CHECK(references_by_face(joined.snapshot) == references_by_face(whole.snapshot));
  for (const auto& view : joined.snapshot.views) {
    const auto& views = whole.snapshot.views;
    const auto same =
        std::find_if(views.begin(), views.end(), [&](const auto& other) { return other && other->name == view->name; });
    REQUIRE(same != views.end());
    CHECK(view->camera.cam_from_world_translation == (*same)->camera.cam_from_world_translation);
  }
}

TEST_CASE("Blocks join to a surface without borders, each face of which is in one block", "[joined_city]") {
  const BuildResult whole = built_in_one_piece();
  const SmallCity city(5000);
  REQUIRE(city.plan.blocks.size() >= 5);
  build_blocks(city.folder.path(), city.plan);
  const JoinedCity joined = join_blocks(city.folder.path(), city.plan, {});
  check(joined.snapshot);
  const Surface& surface = *joined.snapshot.surface;
  // The same faces as in one piece, which meet at the same vertices.
  CHECK(surface.mesh.faces.size() == whole.snapshot.surface->mesh.faces.size());
  CHECK(surface.mesh.positions.size() == whole.snapshot.surface->mesh.positions.size());
  CHECK(surface.cells.cells.size() == whole.snapshot.surface->cells.cells.size());
  // A photograph sees a block in the same way however the rest is cut: nearly all faces refer to the same photographs.
  const auto of_whole = references_by_face(whole.snapshot), of_joined = references_by_face(joined.snapshot);
  REQUIRE(of_whole.size() == of_joined.size());
  std::size_t same = 0, bare = 0;
  for (const auto& [place, names] : of_joined) {
    const auto before = of_whole.find(place);
    REQUIRE(before != of_whole.end());
    same += before->second == names ? 1 : 0;
    bare += names.empty() && !before->second.empty() ? 1 : 0;
  }
  CHECK(same > of_joined.size() * 9 / 10);
  CHECK(bare < of_joined.size() / 200);
  // Each reference shows something: its view has a tile.
  for (ViewSlot slot{0}; slot < joined.snapshot.views.size(); ++slot) {
    CHECK(joined.snapshot.tiles.has_resident_tile(slot));
  }
}

TEST_CASE("A block that is missing, or of another plan, is named", "[joined_city]") {
  using Catch::Matchers::Contains;
  const SmallCity city(1'000'000);
  CHECK_THROWS_WITH(join_blocks(city.folder.path(), city.plan, {}), Contains("block 0 of 2 is missing"));
  build_blocks(city.folder.path(), city.plan);
  CHECK(is_block_done(city.folder.path(), city.plan, 1));
  CityPlan other = city.plan;
  other.stamp = "another";
  CHECK(!is_block_done(city.folder.path(), other, 1));
  CHECK_THROWS_AS(build_block(city.folder.path(), city.plan, 2, {}), std::invalid_argument);
}

}  // namespace lumatlas
