// SPDX-License-Identifier: GPL-3.0-or-later
// Models that say where they are on the Earth.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <glm/glm.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "atlas/model/gltf/gltf_cameras.h"
#include "atlas/model/model_file.h"
#include "mesh/base/errors.h"
#include "tests/support/scenes/plain_model.h"
#include "tests/support/scenes/wall_scenes.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const GeoReference kViennaReference{GeoReference::Frame::east_north_up, 48.2, 16.375, 190.25, {}};
const GeoReference kGeocentricReference{GeoReference::Frame::geocentric, 0, 0, 0, "GEOGCS[\"WGS 84\"]"};

// A model whose offset is the given one.
Snapshot placed_snapshot(const GeoReference& reference, const glm::dvec3& offset) {
  Snapshot snapshot = small_snapshot();
  auto surface = std::make_shared<Surface>(*snapshot.surface);
  surface->offset = offset;
  snapshot.surface = surface;
  snapshot.georeference = reference;
  return snapshot;
}

json placed_tileset_in(const fs::path& folder) {
  return json::parse(bytes_of(folder / kTilesetName));
}

// Returns the matrix of the root.
glm::dmat4 root_transform_of(const json& tileset) {
  const json& numbers = tileset.at("root").at("transform");
  REQUIRE(numbers.size() == 16);
  glm::dmat4 matrix;
  for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = numbers[static_cast<std::size_t>(i)].get<double>();
  return matrix;
}

// Checks that the root's transform takes each vertex, turned as glTF's node turns it and y up made z up, to where the
// scene's coordinates say that it is.
void check_places(const Snapshot& snapshot, const glm::dmat4& geocentric_from_coordinates) {
  const TemporaryFolder folder;
  write_model(folder.path(), snapshot, {});
  const glm::dmat4 transform = root_transform_of(placed_tileset_in(folder.path()));
  CHECK(transform[3][3] == 1);
  const glm::dmat3 upright = gltf_from_scene(snapshot);
  for (const glm::vec3& position : snapshot.surface->mesh.positions) {
    const glm::dvec3 in_gltf = upright * glm::dvec3(position);
    const glm::dvec3 shown = transform * glm::dvec4(in_gltf.x, -in_gltf.z, in_gltf.y, 1);
    const glm::dvec3 coordinates = glm::dvec3(position) + snapshot.surface->offset;
    CHECK(glm::distance(shown, glm::dvec3(geocentric_from_coordinates * glm::dvec4(coordinates, 1))) < 1e-6);
  }
}

TEST_CASE("the root's transform takes a model to its place on the Earth") {
  check_places(placed_snapshot(kViennaReference, {1000, -250, 12.5}), *geocentric_from_scene(kViennaReference));
  check_places(placed_snapshot(kGeocentricReference, {4085000, 1200000, 4732000}), glm::dmat4(1));
}

TEST_CASE("a model without a georeference, or in a system on another ellipsoid, has no transform") {
  const TemporaryFolder plain, bessel;
  write_model(plain.path(), small_snapshot(), {});
  CHECK_FALSE(placed_tileset_in(plain.path()).at("root").contains("transform"));
  CHECK_FALSE(read_model(plain.path()).snapshot.georeference);
  GeoReference other = kGeocentricReference;
  other.system = "GEOGCS[\"DHDN\",DATUM[\"D\",SPHEROID[\"Bessel 1841\",6377397.155,299.1528128]]]";
  write_model(bessel.path(), placed_snapshot(other, glm::dvec3(0)), {});
  CHECK_FALSE(placed_tileset_in(bessel.path()).at("root").contains("transform"));
  CHECK(read_model(bessel.path()).snapshot.georeference == other);
}

TEST_CASE("a georeference reads back, and a model that was read is written as the same bytes") {
  for (const GeoReference& reference : {kViennaReference, kGeocentricReference}) {
    const TemporaryFolder first, second;
    write_model(first.path(), placed_snapshot(reference, {1000, -250, 12.5}), {});
    const Model read = read_model(first.path());
    CHECK(read.snapshot.georeference == reference);
    CHECK(read_model_facts(first.path()).georeference == reference);
    write_model(second.path(), read.snapshot, {});
    CHECK(bytes_of(first / kTilesetName) == bytes_of(second / kTilesetName));
    std::ofstream glb(first / "one.glb", std::ios::binary);
    write_glb(glb, read.snapshot, {});
    glb.close();
    CHECK(read_model(first / "one.glb").snapshot.georeference == reference);
  }
}

TEST_CASE("cameras and surface are the same with and without a georeference") {
  const TemporaryFolder placed, plain;
  Snapshot snapshot = placed_snapshot(kViennaReference, {1000, -250, 12.5});
  write_model(placed.path(), snapshot, {});
  snapshot.georeference.reset();
  write_model(plain.path(), snapshot, {});
  json tileset = placed_tileset_in(placed.path());
  tileset.at("root").erase("transform");
  tileset.at("extensions").at("LUMATLAS_lumigraph").erase("georeference");
  CHECK(tileset == placed_tileset_in(plain.path()));
}

TEST_CASE("a georeference that breaks a rule is neither read nor written") {
  const TemporaryFolder folder;
  write_model(folder.path(), placed_snapshot(kViennaReference, glm::dvec3(0)), {});
  const json good = placed_tileset_in(folder.path());
  const auto sentence = [&](const std::string& name, const json& value) -> std::string {
    json damaged = good;
    json& georeference = damaged.at("extensions").at("LUMATLAS_lumigraph").at("georeference");
    if (name.empty()) {
      georeference = value;
    } else if (value.is_null()) {
      georeference.erase(name);
    } else {
      georeference[name] = value;
    }
    const fs::path file = folder.with_file(kTilesetName, damaged.dump());
    try {
      (void)read_model(folder.path());
    } catch (const InputError& error) {
      return std::string(error.what()).substr(file.string().size() + 2);
    }
    return "accepted";
  };
  CHECK(sentence("latitude", 90) == "accepted");
  CHECK_THAT(sentence("latitude", 90.1), Catch::Contains("latitude") && Catch::Contains("90.1"));
  CHECK_THAT(sentence("longitude", -180.5), Catch::Contains("longitude") && Catch::Contains("-180.5"));
  CHECK_THAT(sentence("altitude", 1e8), Catch::Contains("altitude"));
  CHECK_THAT(sentence("altitude", "high"), Catch::Contains("altitude"));
  CHECK_THAT(sentence("longitude", nullptr), Catch::Contains("longitude"));
  CHECK(sentence("frame", "utm") == "georeference: \"frame\" is 'utm', must be \"east-north-up\" or \"geocentric\"");
  CHECK(sentence("", 3) == "georeference is not an object");
  Snapshot beyond = placed_snapshot(kViennaReference, glm::dvec3(0));
  beyond.georeference->latitude_deg = -91;
  CHECK_THROWS_WITH(write_model(folder.path(), beyond, {}), "georeference: latitude is -91, must be within 90 of 0");
}

}  // namespace
}  // namespace lumatlas
