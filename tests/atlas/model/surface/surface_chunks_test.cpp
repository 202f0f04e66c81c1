// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/surface/surface_chunks.h"

#include <algorithm>
#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "atlas/model/gltf/glb_file.h"
#include "atlas/model/model_file.h"
#include "atlas/model/surface/tile_tree.h"
#include "blend/tables/fade_zone_shares.h"
#include "mesh/base/errors.h"
#include "tests/support/scenes/far_scenes.h"
#include "tests/support/scenes/plain_model.h"
#include "tests/support/scenes/wall_scenes.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// A wall in many cells, seen by two views.
Snapshot snapshot_of_wall(bool far = false, const TileOptions& layout = kWholeViews) {
  auto near = std::make_shared<Surface>();
  add_wall(near->mesh, 24, 20, 0.3f, 4);
  near->cells = make_cells(near->mesh, {.size = 1});
  near->offset = {4.5e6, -12.25, 0.1};
  const std::shared_ptr<const Surface> surface = far ? with_sphere_behind(*near) : near;
  Atlas atlas(surface, 3, layout);
  for (const double aside : {-0.5, 0.7}) {
    const Camera camera = oblique_camera(40, 30, 0.1 * aside, {aside, 0, -2});
    TiledView tiled = make_tiled_view(aside < 0 ? "left" : "right", camera, position_photograph(40, 30),
                                      make_ray_visibility(surface->mesh)->trace(camera), surface->cells, layout, {});
    atlas.insert(std::move(tiled.view), std::move(tiled.shown));
  }
  std::vector<CellPixels> seen;
  for (CellId cell{0}; cell < surface->cells.cells.size(); ++cell) {
    if (cell % 5 != 0) atlas.set_references(cell, {ViewSlot(cell % 2), ViewSlot(1 - cell % 2)});
    if (cell % 7 != 0) seen.push_back({CellId{cell}, 1});
  }
  atlas.mark_seen(seen);
  Snapshot snapshot = atlas.snapshot();
  for (std::size_t cell = 0; cell < snapshot.cell_seen.size(); ++cell) {
    snapshot.cell_coverage.push_back(0.1f * static_cast<float>(cell));
    snapshot.cell_deviation.push_back(0.3f * static_cast<float>(cell));
  }
  return snapshot;
}

constexpr std::size_t kChunkFaces = 150;

std::vector<fs::path> surfaces_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().filename().string().starts_with("surface-")) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// Writes the snapshot as a page's form, into a folder.
void write_packed(const fs::path& folder, const Snapshot& snapshot, std::size_t chunk_faces) {
  write_model(folder, snapshot, {}, {.packed = true, .chunk_faces = chunk_faces});
}

void check_same_to_the_bit(const Snapshot& a, const Snapshot& b) {
  REQUIRE(a.surface->mesh.positions.size() == b.surface->mesh.positions.size());
  CHECK(std::memcmp(a.surface->mesh.positions.data(), b.surface->mesh.positions.data(),
                    sizeof(glm::vec3) * a.surface->mesh.positions.size()) == 0);
  CHECK(a.surface->mesh.faces == b.surface->mesh.faces);
  CHECK(a.surface->offset == b.surface->offset);
  CHECK(a.surface->cells.cell_of_face == b.surface->cells.cell_of_face);
  CHECK(a.surface->cells.size == b.surface->cells.size);
  CHECK(a.surface->far_faces == b.surface->far_faces);
  CHECK(a.surface->far_cells == b.surface->far_cells);
  CHECK(a.references.offsets == b.references.offsets);
  CHECK(a.references.views == b.references.views);
  CHECK(a.cell_seen == b.cell_seen);
  CHECK(a.cell_coverage == b.cell_coverage);
  CHECK(a.cell_deviation == b.cell_deviation);
  CHECK(a.vertex_colors == b.vertex_colors);
  CHECK(a.tiles.places == b.tiles.places);
  REQUIRE(a.views.size() == b.views.size());
  for (std::size_t view = 0; view < a.views.size(); ++view) {
    CHECK(a.views[view]->photograph->whole().rgb == b.views[view]->photograph->whole().rgb);
    CHECK(a.views[view]->mask->depth == b.views[view]->mask->depth);
  }
}

TEST_CASE("chunks are of whole cells, each in one, and of bounded size") {
  Surface surface;
  add_wall(surface.mesh, 40, 30, 0.25f, 4);
  surface.cells = make_cells(surface.mesh, {.size = 0.8});
  std::map<std::uint32_t, std::size_t> faces;
  for (const CellId cell : surface.cells.cell_of_face) ++faces[cell];
  for (const std::size_t most : {std::size_t{1}, std::size_t{100}, std::size_t{317}, std::size_t{1} << 40}) {
    const auto chunks = cells_of_chunks(surface, most);
    CHECK(chunks == cells_of_chunks(surface, most));
    std::set<std::uint32_t> known;
    for (const auto& cells : chunks) {
      std::size_t sum = 0;
      for (const CellId cell : cells) {
        CHECK(known.insert(cell).second);
        sum += faces[cell];
      }
      CHECK((sum <= most || cells.size() == 1));
      CHECK(std::is_sorted(cells.begin(), cells.end()));
    }
    CHECK(known.size() == surface.cells.cells.size());
    // Halves are about as large: no chunk is needlessly small.
    CHECK(chunks.size() <= std::max<std::size_t>(1, std::min(faces.size(), 4 * surface.mesh.faces.size() / most)));
  }
}

TEST_CASE("an origin brings every position back to the bit") {
  std::mt19937 random(3);
  for (const double scale : {1e-30, 1e-3, 1.0, 4e4, 1e30}) {
    for (const double middle : {0.0, 0.3, 1.0, 5.0, 1000.0, -77.7}) {
      std::uniform_real_distribution<double> share(middle - 1, middle + 1);
      std::vector<glm::vec3> positions;
      for (int i = 0; i < 500; ++i) positions.emplace_back(scale * share(random), scale * share(random), -0.0f);
      const glm::dvec3 origin = exact_origin(positions);
      for (const glm::vec3& position : positions) {
        for (int axis = 0; axis < 3; ++axis) {
          const auto stored = static_cast<float>(static_cast<double>(position[axis]) - origin[axis]);
          const float again =
              origin[axis] == 0 ? stored : static_cast<float>(static_cast<double>(stored) + origin[axis]);
          if (std::bit_cast<std::uint32_t>(again) == std::bit_cast<std::uint32_t>(position[axis])) continue;
          FAIL("axis " << axis << ", scale " << scale << ", middle " << middle);
        }
      }
      if (middle == 1000.0) CHECK(std::abs(origin.x / scale - middle) < 1);
    }
  }
  CHECK(exact_origin({}) == glm::dvec3(0));
  CHECK(exact_origin({{0.1f, -0.0f, 3}}).z == 3);
}

TEST_CASE("a model in chunks reads back as the model in one, to the bit") {
  const bool far = GENERATE(false, true);
  const std::uint32_t tile_px = GENERATE(0u, 8u);
  const Snapshot snapshot = snapshot_of_wall(far, {tile_px, 2, 0});
  const CellShares shares = share_cells(*snapshot.surface, 0.3);
  BaseTexture texture = small_texture(near_surface(*snapshot.surface));
  const TemporaryFolder one, several;
  const FormOptions form{.texture = &texture, .shares = &shares};
  FormOptions in_chunks = form;
  in_chunks.chunk_faces = kChunkFaces;
  write_model(one.path(), snapshot, {}, form);
  write_model(several.path(), snapshot, {}, in_chunks);
  REQUIRE(surfaces_in(one.path()).size() == 1);
  REQUIRE(surfaces_in(several.path()).size() >= 7);
  const Snapshot read = read_model(several.path()).snapshot;
  check_same_to_the_bit(read, read_model(one.path()).snapshot);
  const ModelFacts facts = read_model_facts(several.path());
  CHECK(facts.surface->mesh.faces == read.surface->mesh.faces);
  CHECK(std::count_if(facts.uris.begin(), facts.uris.end(),
                      [](const std::string& uri) { return uri.starts_with("images/texture"); }) == 1);

  const TemporaryFolder again;
  in_chunks.texture = nullptr;
  write_model(several.path(), read, {}, in_chunks);
  write_model(again.path(), read_model(several.path()).snapshot, {}, in_chunks);
  for (const fs::path& file : surfaces_in(several.path())) {
    CHECK(bytes_of(file) == bytes_of(again.path() / file.filename()));
  }
  CHECK(bytes_of(several / "tileset.json") == bytes_of(again / "tileset.json"));
}

TEST_CASE("a page's chunks share their borders exactly") {
  const Snapshot snapshot = snapshot_of_wall();
  const TemporaryFolder one, several;
  write_packed(one.path(), snapshot, 1'000'000);
  write_packed(several.path(), snapshot, kChunkFaces);
  REQUIRE(surfaces_in(several.path()).size() >= 7);
  const auto positions = [](const fs::path& folder) {
    std::set<std::array<float, 3>> all;
    const Model model = read_model(folder);
    for (const glm::vec3& p : model.snapshot.surface->mesh.positions) all.insert({p.x, p.y, p.z});
    return all;
  };
  CHECK(positions(several.path()) == positions(one.path()));
}

// The tiles of a tileset below a tile, level by level; and what they are made of.
struct SeenTiles {
  std::vector<std::string> chunks, coarse;
  std::size_t depth = 0;
};

// Adds a tile and those below it. A parent's error is at least that of its children, and its box holds theirs.
void look_at_tiles(const json& tile, std::size_t depth, SeenTiles& seen) {
  seen.depth = std::max(seen.depth, depth);
  if (!tile.contains("children")) {
    seen.chunks.push_back(tile.at("content").at("uri"));
    return;
  }
  if (tile.contains("content")) seen.coarse.push_back(tile.at("content").at("uri"));
  CHECK(tile.at("children").size() <= kChildTiles);
  for (const json& child : tile.at("children")) {
    CHECK(child.at("geometricError") <= tile.at("geometricError"));
    const json &outer = tile.at("boundingVolume").at("box"), &inner = child.at("boundingVolume").at("box");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double apart = std::abs(outer.at(axis).get<double>() - inner.at(axis).get<double>());
      CHECK(apart + std::abs(inner.at(3 + 4 * axis).get<double>()) <=
            std::abs(outer.at(3 + 4 * axis).get<double>()) + 1e-3);
    }
    look_at_tiles(child, depth + 1, seen);
  }
}

TEST_CASE("tiles of many chunks stand in for at most eight others, and the whole is read back") {
  const Snapshot snapshot = snapshot_of_wall();
  const TemporaryFolder several, one;
  write_model(several.path(), snapshot, {}, {.chunk_faces = 40, .coarse_faces = 60});
  write_model(one.path(), snapshot, {}, {});
  const json root = json::parse(bytes_of(several / "tileset.json")).at("root");
  SeenTiles seen;
  look_at_tiles(root, 0, seen);
  CHECK(seen.chunks.size() == surfaces_in(several.path()).size());
  REQUIRE(seen.chunks.size() > kChildTiles);
  CHECK(seen.depth == 2);
  REQUIRE(seen.coarse.size() == 1 + root.at("children").size());
  for (const std::string& name : seen.coarse) {
    const json gltf = glb_json(several.path() / name);
    const auto indices = gltf.at("meshes").at(0).at("primitives").at(0).at("indices").get<std::size_t>();
    const auto corners = gltf.at("accessors").at(indices).at("count").get<std::size_t>();
    CHECK(corners > 0);
    CHECK(corners <= 3 * 120);
  }
  const auto faces = [](const TemporaryFolder& folder) {
    return read_model(folder.path()).snapshot.surface->mesh.faces.size();
  };
  CHECK(faces(several) == faces(one));
}

// The chunks below a tile, and how deep they all are.
std::size_t chunks_below(const TileRange& tile, std::size_t& depth) {
  if (tile.children.empty()) {
    depth = 0;
    return 1;
  }
  CHECK(tile.children.size() <= kChildTiles);
  std::size_t next = tile.first;
  std::set<std::size_t> depths;
  for (const TileRange& child : tile.children) {
    CHECK(child.first == next);
    std::size_t below = 0;
    CHECK(chunks_below(child, below) == child.count);
    depths.insert(below);
    next += child.count;
  }
  CHECK(depths.size() == 1);
  depth = *depths.begin() + 1;
  return next - tile.first;
}

TEST_CASE("a tree of tiles has each chunk once, in order, at one depth") {
  for (const std::size_t chunks : {1, 2, 8, 9, 16, 63, 64, 65, 500, 513}) {
    std::size_t depth = 0;
    CHECK(chunks_below(tile_tree(chunks), depth) == chunks);
    CHECK(depth == (chunks == 1 ? 0 : chunks <= 8 ? 1 : chunks <= 64 ? 2 : chunks <= 512 ? 3 : 4));
  }
}

TEST_CASE("a tileset has a tile for each chunk, with its box, below the coarse surface or an empty root") {
  const Snapshot snapshot = snapshot_of_wall(true);
  const CellShares shares = share_cells(*snapshot.surface, 0.3);
  const TemporaryFolder folder;
  write_model(folder.path(), snapshot, {}, {.shares = &shares, .chunk_faces = kChunkFaces});
  const json root = json::parse(bytes_of(folder / "tileset.json")).at("root");
  CHECK(!root.contains("content"));
  CHECK(root.at("geometricError") > 0);
  REQUIRE(root.at("children").size() == surfaces_in(folder.path()).size());
  std::size_t far = 0, guests = 0, aside = 0;
  for (const json& tile : root.at("children")) {
    CHECK(tile.at("geometricError") == 0);
    const json gltf = glb_json(folder.path() / tile.at("content").at("uri").get<std::string>());
    const json& lumigraph = gltf.at("extensions").at("LUMATLAS_lumigraph");
    far += lumigraph.contains("far") ? 1 : 0;
    guests += lumigraph.value("guestCells", std::size_t{0});
    CHECK(gltf.at("nodes").at(1).at("translation") == lumigraph.at("origin"));
    const json box = tile.at("content").at("extras").at("box");
    const json position =
        gltf.at("accessors")
            .at(gltf.at("meshes").at(0).at("primitives").at(0).at("attributes").at("POSITION").get<std::size_t>());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double origin = lumigraph.at("origin").at(axis).get<double>();
      CHECK(box.at(axis).get<double>() == Approx(position.at("min").at(axis).get<double>() + origin).margin(1e-4));
      CHECK(box.at(axis + 3).get<double>() == Approx(position.at("max").at(axis).get<double>() + origin).margin(1e-4));
    }
    // Turned upright, a box around the same vertices is at most sqrt(3) times as long across.
    const json& volume = tile.at("boundingVolume").at("box");
    const auto at = [](const json& numbers, std::size_t i) { return numbers.at(i).get<double>(); };
    const double across = std::hypot(at(box, 3) - at(box, 0), at(box, 4) - at(box, 1), at(box, 5) - at(box, 2));
    const glm::dvec3 half(at(volume, 3), at(volume, 7), at(volume, 11)),
        middle(at(volume, 0), at(volume, 1), at(volume, 2));
    CHECK(2 * glm::length(half) <= 1.74 * across);
    aside += glm::length(middle) > 2 * glm::length(half) ? 1 : 0;
  }
  CHECK(far == 1);
  CHECK(guests > 0);
  CHECK(aside > 0);  // and not around the origin of the scene
}

TEST_CASE("a chunk of no face is no chunk size") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(write_model(folder.path(), small_snapshot(), {}, {.chunk_faces = 0}),
                    "form: chunk_faces is 0, must be at least 1");
}

// A good model in chunks, to be damaged.
class DamagedChunks {
 public:
  DamagedChunks() {
    const Snapshot snapshot = snapshot_of_wall(true, {8, 2, 0});
    const CellShares shares = share_cells(*snapshot.surface, 0.3);
    write_model(folder_.path(), snapshot, {}, {.shares = &shares, .chunk_faces = kChunkFaces});
    tileset = json::parse(bytes_of(folder_ / "tileset.json"));
    for (const json& tile : tileset.at("root").at("children")) names_.push_back(tile.at("content").at("uri"));
  }

  // Changes the extension in the file of a chunk.
  void change(std::size_t chunk,
              const std::function<void(json& lumigraph, json& gltf, std::vector<unsigned char>& buffer)>& damage) {
    const fs::path file = folder_ / names_[chunk];
    const GlbFrame frame = read_glb_frame(file);
    std::vector<unsigned char> buffer = read_glb_binary(file, frame, frame.binary_bytes);
    json gltf = json::parse(frame.json);
    damage(gltf["extensions"]["LUMATLAS_lumigraph"], gltf, buffer);
    std::ofstream stream(file, std::ios::binary);
    write_glb_frame(stream, gltf.dump(), buffer);
  }
  // Overwrites a number of the accessor `name` of a chunk.
  void poke(std::size_t chunk, const char* name, std::size_t index, std::uint32_t value) {
    change(chunk, [&](json& lumigraph, json& gltf, std::vector<unsigned char>& buffer) {
      const json& accessor = gltf["accessors"][lumigraph[name].get<std::size_t>()];
      const json& view = gltf["bufferViews"][accessor["bufferView"].get<std::size_t>()];
      std::memcpy(&buffer[view.value("byteOffset", std::size_t{0}) + 4 * index], &value, 4);
    });
  }
  [[nodiscard]] const std::string& name(std::size_t chunk) const { return names_[chunk]; }

  [[nodiscard]] std::string sentence() const {
    (void)folder_.with_file("tileset.json", tileset.dump());
    try {
      (void)read_model(folder_.path());
    } catch (const InputError& error) {
      std::string text = error.what();
      const std::string start = folder_.path().string() + "/";
      return text.starts_with(start) ? text.substr(start.size()) : text;
    }
    return "accepted";
  }

  json tileset;

 private:
  TemporaryFolder folder_;
  std::vector<std::string> names_;
};

TEST_CASE("chunks that do not fit together are refused in one sentence") {
  using Damage = std::function<std::string(DamagedChunks&)>;  // returns the sentence
  const auto set = [](std::size_t chunk, const char* name, json value) {
    return [=](DamagedChunks& model) {
      model.change(chunk, [&](json& lumigraph, json&, const std::vector<unsigned char>&) { lumigraph[name] = value; });
    };
  };
  const std::vector<std::pair<const char*, Damage>> cases{
      {"nothing", [](DamagedChunks&) { return std::string("accepted"); }},
      {"a chunk twice",
       [](DamagedChunks& m) {
         m.tileset["root"]["children"].push_back(m.tileset["root"]["children"][0]);
         return "tileset.json: two tiles have the surface " + m.name(0) + ", each must have its own";
       }},
      {"children that are no list",
       [](DamagedChunks& m) {
         m.tileset["root"]["children"] = 3;
         return std::string("tileset.json: \"children\" is not an array");
       }},
      {"a third level",
       [](DamagedChunks& m) {
         json& children = m.tileset["root"]["children"];
         children[0] = {{"children", json::array({children[0], children[1]})}};
         children.erase(1);
         return std::string("accepted");
       }},
      {"a third level with a chunk twice",
       [](DamagedChunks& m) {
         json& children = m.tileset["root"]["children"];
         children[1]["children"] = json::array({children[0]});
         return "tileset.json: two tiles have the surface " + m.name(0) + ", each must have its own";
       }},
      {"a chunk missing",
       [](DamagedChunks& m) {
         m.tileset["root"]["children"].erase(1);
         return std::string("number");
       }},
      {"another offset",
       [&](DamagedChunks& m) {
         set(1, "offset", {1, 2, 3})(m);
         return m.name(1) + ": has another \"offset\" than " + m.name(0);
       }},
      {"another cell size",
       [&](DamagedChunks& m) {
         set(2, "cellSize", 0.5)(m);
         return m.name(2) + ": has another \"cellSize\" than " + m.name(0);
       }},
      {"an origin of two numbers",
       [&](DamagedChunks& m) {
         set(1, "origin", {1, 2})(m);
         return m.name(1) + ": LUMATLAS_lumigraph: \"origin\" is not an array of 3 numbers";
       }},
      {"an origin far away",
       [&](DamagedChunks& m) {
         set(1, "origin", {1, 2, 1e39})(m);
         return m.name(1) + ": LUMATLAS_lumigraph: \"origin\"";
       }},
      {"no guests although zones have them",
       [&](DamagedChunks& m) {
         m.change(1, [](json& lumigraph, json&, const std::vector<unsigned char>&) { lumigraph.erase("guestCells"); });
         return std::string("zone");
       }},
      {"half a guest",
       [&](DamagedChunks& m) {
         set(1, "guestCells", 0.5)(m);
         return m.name(1) + ": LUMATLAS_lumigraph: \"guestCells\"";
       }},
      {"more guests",
       [&](DamagedChunks& m) {
         set(1, "guestCells", 5000)(m);
         return m.name(1) + ": referenceOffsets has ";
       }},
      {"another version",
       [&](DamagedChunks& m) {
         set(1, "version", 4)(m);
         return m.name(1) + ": has version 4 of LUMATLAS_lumigraph: it was made by an older lumatlas, build it again";
       }},
      {"no runs in one",
       [&](DamagedChunks& m) {
         m.change(1, [](json& lumigraph, json&, const std::vector<unsigned char>&) { lumigraph.erase("faceRuns"); });
         return m.name(1) + ": has no faceRuns, unlike " + m.name(0);
       }},
      {"a cell in two chunks",
       [&](DamagedChunks& m) {
         m.poke(1, "cellRuns", 0, 0);
         return std::string("cellRuns has the number ");
       }},
      {"a vertex beyond the last",
       [&](DamagedChunks& m) {
         m.poke(1, "vertexRuns", 0, 999'999'999);
         return std::string("vertexRuns has the number 999999999 of ");
       }},
      {"a number beyond all",
       [&](DamagedChunks& m) {
         m.poke(1, "vertexRuns", 0, 0xffffffff);
         return m.name(1) + ": vertexRuns does not give ";
       }},
      {"a run without end",
       [&](DamagedChunks& m) {
         m.poke(1, "faceRuns", 1, 0xffffffff);
         return m.name(1) + ": faceRuns does not give ";
       }},
      {"a run too short",
       [&](DamagedChunks& m) {
         m.poke(1, "faceRuns", 1, 0);
         return m.name(1) + ": faceRuns does not give ";
       }},
      {"half a run",
       [&](DamagedChunks& m) {
         m.change(1, [](json& lumigraph, json& gltf, const std::vector<unsigned char>&) {
           json& count = gltf["accessors"][lumigraph["faceRuns"].get<std::size_t>()]["count"];
           count = count.get<std::size_t>() - 1;
         });
         return std::string(", must have pairs");
       }},
      {"coverage in all but one",
       [&](DamagedChunks& m) {
         m.change(2,
                  [](json& lumigraph, json&, const std::vector<unsigned char>&) { lumigraph.erase("cellCoverage"); });
         return m.name(2) + ": has no cellCoverage, unlike " + m.name(0);
       }},
      {"no tiles",
       [&](DamagedChunks& m) {
         m.change(0, [](json& lumigraph, json&, const std::vector<unsigned char>&) { lumigraph.erase("resident"); });
         return m.name(0) + ": \"resident\" says of 0 tiles";
       }},
  };
  for (const auto& [what, damage] : cases) {
    CAPTURE(what);
    DamagedChunks model;
    const std::string expected = damage(model);
    CHECK_THAT(model.sentence(), Catch::Contains(expected));
  }
}

}  // namespace
}  // namespace lumatlas
