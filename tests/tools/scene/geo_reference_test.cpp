// SPDX-License-Identifier: GPL-3.0-or-later
// Georeferences as an option's text and as a file beside a scene.
#include "tools/scene/geo_reference.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

const GeoReference kSydney{GeoReference::Frame::east_north_up, -33.86, 151.21, 20.5, {}};

TEST_CASE("a georeference is read from the text of an option") {
  for (const char* const text : {"-33.86,151.21,20.5", "(-33.86, 151.21, 20.5)", " -33.86 ,151.21, 20.5 "}) {
    CHECK(parse_geo_reference(text) == kSydney);
  }
  CHECK(parse_geo_reference("0,0,0") == GeoReference{});
  CHECK(parse_geo_reference("geocentric") == GeoReference{GeoReference::Frame::geocentric, 0, 0, 0, {}});
  CHECK(text_of(parse_geo_reference("geocentric")) == "metres from the Earth's centre (geocentric), of WGS 84");
}

TEST_CASE("a text that is no georeference is refused, and the sentence says why") {
  const auto sentence = [](const std::string& text) -> std::string {
    try {
      (void)parse_geo_reference(text);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  for (const char* const text : {"", "48.2", "48.2,16.4", "48.2,16.4,190,5", "48.2,16.4,", "48.2N,16.4,190", "ecef"}) {
    CHECK_THAT(sentence(text), Catch::StartsWith(text + std::string(" is not three numbers: give latitude")));
  }
  CHECK_THAT(sentence("90.01,0,0"), Catch::StartsWith("90.01,0,0 has a latitude beyond 90 degrees"));
  CHECK_THAT(sentence("0,-200,0"), Catch::StartsWith("0,-200,0 has a longitude beyond 180 degrees"));
  CHECK_THAT(sentence("0,0,1e9"), Catch::StartsWith("0,0,1e9 has an altitude beyond 10000000 metres"));
  CHECK_THAT(sentence("nan,0,0"), Catch::StartsWith("nan,0,0 has a latitude"));
}

TEST_CASE("a georeference is read from the file of OpenSfM beside a scene, or in OpenDroneMap's folder of it") {
  const TemporaryFolder folder;
  CHECK_FALSE(reference_beside(folder.path()));
  CHECK_FALSE(reference_file_beside(folder.path()));
  fs::create_directory(folder / "opensfm");
  const fs::path inner =
      folder.with_file("opensfm/reference_lla.json", R"({"latitude": 1.5, "longitude": 2.5, "altitude": 3})");
  CHECK(reference_beside(folder.path()) == GeoReference{GeoReference::Frame::east_north_up, 1.5, 2.5, 3, {}});
  CHECK(reference_file_beside(folder.path()) == inner);
  (void)folder.with_file("reference_lla.json", R"({"altitude": 20.5, "latitude": -33.86, "longitude": 151.21})");
  CHECK(reference_beside(folder.path()) == kSydney);
  (void)folder.with_file("reference_lla.json", R"({"latitude": -33.86, "longitude": 151.21})");
  CHECK(reference_beside(folder.path())->altitude_m == 0);
  (void)folder.with_file("reference_lla.json", R"({"altitude": 0, "latitude": 0.0, "longitude": 0})");
  CHECK_FALSE(reference_beside(folder.path()));
}

TEST_CASE("a file that holds no georeference is refused by name, place and value") {
  const TemporaryFolder folder;
  const auto sentence = [&](const std::string& text) -> std::string {
    const fs::path file = folder.with_file("reference_lla.json", text);
    try {
      (void)reference_beside(folder.path());
    } catch (const InputError& error) {
      const std::string said = error.what();
      REQUIRE(said.starts_with(file.string() + ": "));
      return said.substr(file.string().size() + 2);
    }
    return "accepted";
  };
  CHECK(sentence(R"({"latitude": 91, "longitude": 0, "altitude": 0})") ==
        "georeference: latitude is 91, must be within 90 of 0");
  CHECK_THAT(sentence(R"({"latitude": "north", "longitude": 0})"), Catch::StartsWith("latitude: "));
  CHECK_THAT(sentence(R"({"latitude": 1})"), Catch::Contains("longitude"));
  CHECK(sentence("[1, 2, 3]") == "has no \"latitude\"");
  CHECK(sentence("48.2 16.4") != "accepted");
  CHECK(sentence("") != "accepted");
}

}  // namespace
}  // namespace lumatlas
