// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "atlas/model/model_file.h"
#include "atlas/model/surface/chunked_surface.h"
#include "blend/blend_options.h"
#include "blend/tables/fade_zone_shares.h"
#include "mesh/base/errors.h"
#include "tests/tools/city/small_city.h"
#include "tools/city/block_job.h"
#include "tools/city/joining/join_blocks.h"
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

// Writes the joined city, and reads it again.
Model joined_model(const SmallCity& city, const JoinOptions& options = {}) {
  const TemporaryFolder folder;
  JoinedCity joined(city.folder.path(), city.plan, options, {});
  write_model(folder.path(), joined.model(), joined.validity());
  Model model = read_model(folder.path());
  check(model.snapshot);
  CHECK(model.snapshot.surface->mesh.faces.size() == joined.faces());
  CHECK(model.snapshot.views.size() == joined.views());
  CHECK(model.snapshot.cell_seen.size() == joined.cells());
  return model;
}

std::set<Corner> vertex_places(const Surface& surface) {
  std::set<Corner> places;
  for (const glm::vec3& p : surface.mesh.positions) places.insert({p.x, p.y, p.z});
  return places;
}

}  // namespace

TEST_CASE("A city of one block refers to the photographs that build refers to", "[joined_city]") {
  const BuildResult whole = built_in_one_piece();
  const SmallCity city(1'000'000);
  REQUIRE(city.plan.blocks.size() == 2);  // and the far sphere
  build_blocks(city.folder.path(), city.plan);
  const Model joined = joined_model(city);
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
  const Model joined = joined_model(city);
  const Surface& surface = *joined.snapshot.surface;
  // The same faces as in one piece, which meet at the same vertices.
  CHECK(surface.mesh.faces.size() == whole.snapshot.surface->mesh.faces.size());
  CHECK(vertex_places(surface).size() == vertex_places(*whole.snapshot.surface).size());
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

TEST_CASE("Whatever the chunks of a joined city are, its cells fade as those of one surface", "[joined_city]") {
  const SmallCity city(5000);
  build_blocks(city.folder.path(), city.plan);
  const TemporaryFolder folder;
  JoinOptions options;
  options.chunk_faces = 2000;
  JoinedCity joined(city.folder.path(), city.plan, options, {});
  write_model(folder.path(), joined.model(), joined.validity());
  REQUIRE(chunk_files(folder.path()).size() >= 8);
  const Model model = read_model(folder.path());
  const Snapshot& snapshot = model.snapshot;
  const CellShares whole = drawn_shares(*snapshot.surface, snapshot.references, BlendOptions{}.border_width);
  // The same from the pieces, which know their surroundings alone: each face fades between as many cells, and refers
  // to the same photographs with the same shares.
  JoinedCity again(city.folder.path(), city.plan, options, {});
  PiecewiseModel pieces = again.model();
  std::size_t face = 0, faces = 0;
  for (const CityBlock& block : city.plan.blocks) {
    if (block.far) continue;
    const SurfacePiece piece = pieces.surface.next();
    REQUIRE(piece.shares);
    for (std::size_t own = 0; own < block.size.faces; ++own, ++face) {
      const CellShares::Zone& there = whole.zones[whole.zone_of_face[face]];
      const CellShares::Zone& here = piece.shares->zones[piece.shares->zone_of_face[own]];
      const auto count = [](const CellShares::Zone& zone) {
        return std::count_if(zone.begin(), zone.end(), [](CellId cell) { return cell != CellId::none; });
      };
      REQUIRE(count(there) == count(here));
      for (std::size_t i = 0; i < there.size() && count(there) == 1; ++i) {
        CHECK(piece.shares->corners[own].at(0) == whole.corners[face].at(0));
      }
      ++faces;
    }
  }
  CHECK(faces == snapshot.surface->near_faces());
}

TEST_CASE("A joined city has a base texture for each chunk", "[joined_city]") {
  const SmallCity city(5000);
  build_blocks(city.folder.path(), city.plan);
  JoinOptions options;
  options.chunk_faces = 3000;
  options.texture_px = 512;
  const TemporaryFolder folder, plain;
  JoinedCity joined(city.folder.path(), city.plan, options, {});
  write_model(folder.path(), joined.model(), joined.validity());
  CHECK(joined.chunks_without_texture() == 0);
  const std::size_t chunks = chunk_files(folder.path()).size();
  std::set<std::string> textures;
  for (const auto& [name, bytes] : files_of(folder.path())) {
    if (name.starts_with("images/texture-")) textures.insert(name);
  }
  CHECK(textures.size() == chunks);
  CHECK(read_model_facts(folder.path()).texture_bytes > 0);
  check(read_model(folder.path()).snapshot);
  // The same bytes again.
  JoinedCity again(city.folder.path(), city.plan, options, {});
  write_model(plain.path(), again.model(), again.validity());
  CHECK(files_of(plain.path()) == files_of(folder.path()));
}

TEST_CASE("A block that is missing, or of another plan, is named", "[joined_city]") {
  using Catch::Matchers::Contains;
  const SmallCity city(1'000'000);
  CHECK_THROWS_WITH(joined_model(city), Contains("block 0 of 2 is missing"));
  build_blocks(city.folder.path(), city.plan);
  CHECK(is_block_done(city.folder.path(), city.plan, 1));
  CityPlan other = city.plan;
  other.stamp = "another";
  CHECK(!is_block_done(city.folder.path(), other, 1));
  CHECK_THROWS_AS(build_block(city.folder.path(), city.plan, 2, {}), std::invalid_argument);
}

TEST_CASE("A block whose marker a workflow engine has removed is made again", "[joined_city]") {
  const SmallCity city(1'000'000);
  build_blocks(city.folder.path(), city.plan);
  const std::filesystem::path block = city.folder.path() / "blocks" / "0";
  const auto whole = files_of(block);
  REQUIRE(whole.contains("tileset.json"));
  std::filesystem::remove(block / "lumatlas.json");
  CHECK_FALSE(is_block_done(city.folder.path(), city.plan, 0));
  (void)build_block(city.folder.path(), city.plan, 0, {});
  CHECK(is_block_done(city.folder.path(), city.plan, 0));
  const auto again = files_of(block);
  CHECK(again.size() == whole.size());
  CHECK(again.at("tileset.json") == whole.at("tileset.json"));
}

}  // namespace lumatlas
