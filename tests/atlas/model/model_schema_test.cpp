// SPDX-License-Identifier: GPL-3.0-or-later
// Models are written as atlas/LUMATLAS_lumigraph.schema.json says, no more and no less.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "atlas/model/model_file.h"
#include "tests/support/scenes/far_scenes.h"
#include "tests/support/scenes/plain_model.h"
#include "tests/support/scenes/wall_scenes.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

using nlohmann::json;

json schema() {
  return json::parse(bytes_of(LUMATLAS_SCHEMA));
}

// Checks as much of JSON Schema 2020-12 as that schema uses; any other keyword is an error. It is stricter in one
// thing: a property that the schema does not list is wrong.
class Checker {
 public:
  explicit Checker(const json& root) : root_(root) {}

  [[nodiscard]] std::vector<std::string> errors(const json& value) {
    errors_.clear();
    check(root_, value, "");
    return errors_;
  }

 private:
  void require(bool holds, const std::string& where, const std::string& rule) {
    if (!holds) errors_.push_back(where + ": " + rule);
  }

  void check(const json& rules, const json& value, const std::string& where) {
    for (const auto& [keyword, rule] : rules.items()) check_keyword(keyword, rule, rules, value, where);
  }

  void check_keyword(const std::string& keyword, const json& rule, const json& rules, const json& value,
                     const std::string& where) {
    if (keyword == "$ref") {
      check(root_.at(json::json_pointer(rule.get<std::string>().substr(1))), value, where);
    } else if (keyword == "type") {
      require(has_type(value, rule), where, "must be of type " + rule.get<std::string>());
    } else if (keyword == "const") {
      require(value == rule, where, "must be " + rule.dump());
    } else if (keyword == "enum") {
      require(std::find(rule.begin(), rule.end(), value) != rule.end(), where, "must be one of " + rule.dump());
    } else if (keyword == "required") {
      for (const json& name : rule) require(value.contains(name), where, "must have " + name.dump());
    } else if (keyword == "properties") {
      for (const auto& [name, part] : value.items()) {
        require(rule.contains(name), where, "must not have " + name);
        if (rule.contains(name)) check(rule[name], part, where + "/" + name);
      }
    } else if (keyword == "items") {
      for (const json& item : value) check(rule, item, where + "[]");
    } else if (keyword != "description" && keyword != "title" && !(keyword[0] == '$' && &rules == &root_)) {
      check_number(keyword, rule, value, where);
    }
  }

  void check_number(const std::string& keyword, const json& rule, const json& value, const std::string& where) {
    const auto limit = rule.get<double>();
    const auto measure = keyword.ends_with("Items") ? static_cast<double>(value.size()) : value.get<double>();
    if (keyword == "minimum" || keyword == "minItems") {
      require(measure >= limit, where, keyword);
    } else if (keyword == "maximum" || keyword == "maxItems") {
      require(measure <= limit, where, keyword);
    } else if (keyword == "exclusiveMinimum") {
      require(measure > limit, where, keyword);
    } else if (keyword == "multipleOf") {
      require(std::fmod(measure, limit) == 0, where, keyword);
    } else {
      require(false, where, "unknown keyword " + keyword);
    }
  }

  static bool has_type(const json& value, const std::string& type) {
    if (type == "integer") return value.is_number_integer();
    if (type == "number") return value.is_number();
    return type == value.type_name();
  }

  const json& root_;
  std::vector<std::string> errors_;
};

// Each face is its own cell's.
CellShares own_shares(const Surface& surface) {
  CellShares shares;
  for (CellId cell{0}; cell < surface.cells.cells.size(); ++cell) {
    shares.zones.push_back({CellId{cell}, CellId::none, CellId::none, CellId::none});
  }
  shares.zone_of_face.assign(surface.cells.cell_of_face.begin(), surface.cells.cell_of_face.end());
  const glm::vec4 all(1, 0, 0, 0);
  shares.corners.assign(surface.cells.cell_of_face.size(), {all, all, all});
  return shares;
}

json written_extension(const Snapshot& snapshot, bool textured = false, std::size_t listed_views = 200) {
  const TemporaryFolder folder;
  const BaseTexture texture = small_texture(*snapshot.surface);
  const CellShares shares = own_shares(*snapshot.surface);
  FormOptions form{.texture = textured ? &texture : nullptr, .shares = &shares};
  form.listed_views = listed_views;
  write_model(folder.path(), snapshot, {}, form);
  return lumigraph_of(folder.path());
}

const GeoReference kSchemaOrigin{GeoReference::Frame::east_north_up, 48.2, 16.375, 190.25, {}};
const GeoReference kSchemaGeocentric{GeoReference::Frame::geocentric, 0, 0, 0, "GEOGCS[\"WGS 84\"]"};

json written_with(const GeoReference& reference) {
  Snapshot snapshot = small_snapshot();
  snapshot.georeference = reference;
  return written_extension(snapshot);
}

// Returns the properties of a model's chunks, of each the last that has it. All cells fade with the first one.
json written_chunk(const Snapshot& snapshot) {
  const TemporaryFolder folder;
  CellShares shares = own_shares(*snapshot.surface);
  for (CellShares::Zone& zone : shares.zones) {
    if (zone[0] != 0) zone = {CellId{0}, zone[0], CellId::none, CellId::none};
  }
  write_model(folder.path(), snapshot, {}, {.shares = &shares, .chunk_faces = 1});
  json properties = json::object();
  const json tileset = json::parse(bytes_of(folder / "tileset.json"));
  for (const json& tile : tileset.at("root").at("children")) {
    const json gltf = glb_json(folder.path() / tile.at("content").at("uri").get<std::string>());
    properties.update(gltf.at("extensions").at("LUMATLAS_lumigraph"));
  }
  return properties;
}

TEST_CASE("what is written passes the schema") {
  const json rules = schema();
  Checker checker(rules);
  CHECK(checker.errors(written_extension(small_snapshot())).empty());
  CHECK(checker.errors(written_extension(small_snapshot({}, {8, 2, 0}))).empty());
  CHECK(checker.errors(written_extension(small_snapshot(), true)).empty());
  CHECK(checker.errors(written_extension(small_snapshot(), true, 1)).empty());
  CHECK(checker.errors(written_extension(Atlas(wall_and_panel(), 2).snapshot())).empty());
  CHECK(checker.errors(written_extension(far_snapshot())).empty());
  CHECK(checker.errors(written_chunk(far_snapshot())).empty());
  for (const GeoReference& reference : {kSchemaOrigin, kSchemaGeocentric})
    CHECK(checker.errors(written_with(reference)).empty());
}

// Names of properties of an object and of the objects in it.
void names_in(const json& value, std::vector<std::string>& names) {
  if (value.is_array() && !value.empty() && value[0].is_object()) {
    for (const json& item : value) names_in(item, names);
  }
  if (!value.is_object()) return;
  for (const auto& [name, part] : value.items()) {
    names.push_back(name);
    names_in(part, names);
  }
}

TEST_CASE("every property of the schema is written, except glTF's own") {
  std::vector<std::string> written, listed;
  Snapshot snapshot = small_snapshot({}, {8, 2, 0});
  snapshot.cell_coverage.assign(snapshot.cell_seen.size(), 0.5f);
  snapshot.cell_deviation.assign(snapshot.cell_seen.size(), 0.5f);
  names_in(written_extension(snapshot, true), written);
  names_in(written_extension(snapshot, true, 1), written);
  names_in(written_extension(far_snapshot()), written);
  names_in(written_chunk(small_snapshot()), written);
  for (const GeoReference& reference : {kSchemaOrigin, kSchemaGeocentric}) names_in(written_with(reference), written);
  const json rules = schema();
  for (const json& object :
       {rules, rules["$defs"]["view"], rules["properties"]["tiles"], rules["properties"]["validity"],
        rules["properties"]["far"], rules["properties"]["georeference"], rules["properties"]["viewFile"],
        rules["$defs"]["image"]}) {
    for (const auto& [name, part] : object.at("properties").items()) listed.push_back(name);
  }
  for (const std::string& name : listed) {
    if (name == "extras" || name == "extensions" || name == "coarse") continue;  // small models have no coarse mesh
    CAPTURE(name);
    CHECK(std::count(written.begin(), written.end(), name) > 0);
  }
}

TEST_CASE("the schema refuses what the reader refuses") {
  const json good = written_extension(small_snapshot({}, {8, 2, 0}), true);
  const json rules = schema();
  Checker checker(rules);
  REQUIRE(checker.errors(good).empty());
  const std::vector<std::pair<const char*, json>> wrong{
      {"/version", 3},
      {"/vertexCopies", -1},
      {"/origin", {1, 2}},
      {"/guestCells", 0},
      {"/cellRuns", -1},
      {"/vertexRuns", -1},
      {"/faceRuns", -1},
      {"/offset", {1, 2}},
      {"/offset/2", 1e39},
      {"/cellSize", -1},
      {"/cellSeen", -1},
      {"/references", 0.5},
      {"/validity/depthEdge", 0},
      {"/validity/depthEdge", 1e7},
      {"/validity/fade", 17},
      {"/validity/edges", "near"},
      {"/texels", "bc1"},
      {"/tiles/size", 12},
      {"/tiles/size", 2048},
      {"/tiles/gutter", 3},
      {"/views", json::array()},
      {"/views/1/width", 0},
      {"/views/1/height", 65537},
      {"/views/1/name", 3},
      {"/views/1/focalLength/0", 0},
      {"/views/1/rotation/9", 0},
      {"/views/1/translation/0", -1e14},
      {"/views/1/gain/2", 1.1e6},
      {"/views/1/mask", -1},
      {"/views/1/depth", -1},
      {"/up", {0, 1}},
      {"/firstView", -1},
      {"/zoneCells", 0.5},
      {"/poster", -1},
      {"/images/0/uri", 3},
  };
  for (const auto& [place, value] : wrong) {
    json damaged = good;
    damaged[json::json_pointer(place)] = value;
    CAPTURE(place);
    CHECK(checker.errors(damaged).size() == 1);
  }
  for (const char* object : {"", "/validity", "/tiles", "/views/1"}) {
    const json::json_pointer pointer(object);
    for (const auto& [name, part] : good[pointer].items()) {
      json damaged = good;
      damaged[pointer].erase(name);
      const bool optional = name == "references" || name == "views" || name == "tiles" || name == "resident" ||
                            name == "lensMask" || name == "trustMask" || name == "edges" || name == "texels" ||
                            name == "vertexCopies" || name == "mask" || name == "thumbnail" || name == "depth" ||
                            name == "images" || name == "poster" || name == "up" || name == "firstView" ||
                            name == "zoneCells" || name == "offset" || name == "cellSize" || name == "cellSeen" ||
                            name == "referenceOffsets" || name == "validity";
      CAPTURE(object, name);
      CHECK(checker.errors(damaged).size() == (optional ? 0 : 1));
    }
  }
}

}  // namespace
}  // namespace lumatlas
