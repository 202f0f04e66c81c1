// SPDX-License-Identifier: GPL-3.0-or-later
// Coordinates on the Earth come back when a model is exported in the scene's axes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/tools/cli/program.h"
#include "tests/tools/cli/program_here.h"
#include "tools/scene/scene.h"

namespace lumatlas {
namespace {

using nlohmann::json;

const json kPlace{{"frame", "east-north-up"}, {"latitude", 48.25}, {"longitude", -2.125}, {"altitude", 130.5}};

// Writes the shared scene as OpenSfM does, with a reference on the Earth.
void write_as_opensfm(const fs::path& folder) {
  fs::copy(made().scene + "/images", folder / "images");
  fs::copy(made().scene + "/mesh.ply", folder / "mesh.ply");
  json cameras, shots;
  for (const SceneView& view : read_scene_views(made().scene, glm::dvec3(0)).views) {
    const Camera& camera = view.camera;
    const double side = std::max(camera.width, camera.height);
    cameras["one"] = {{"projection_type", "brown"},
                      {"width", camera.width},
                      {"height", camera.height},
                      {"focal_x", camera.fx / side},
                      {"focal_y", camera.fy / side},
                      {"c_x", (camera.cx - camera.width / 2.0) / side},
                      {"c_y", (camera.cy - camera.height / 2.0) / side},
                      {"k1", 0},
                      {"k2", 0},
                      {"k3", 0},
                      {"p1", 0},
                      {"p2", 0}};
    const glm::dquat turn = glm::quat_cast(camera.cam_from_world_rotation);
    const glm::dvec3 r = glm::angle(turn) * glm::axis(turn), t = camera.cam_from_world_translation;
    shots[view.name] = {{"camera", "one"}, {"rotation", {r.x, r.y, r.z}}, {"translation", {t.x, t.y, t.z}}};
  }
  const json place{{"latitude", kPlace["latitude"]}, {"longitude", kPlace["longitude"]}, {"altitude", 130.5}};
  std::ofstream(folder / "reconstruction.json")
      << json::array({{{"cameras", cameras}, {"shots", shots}, {"reference_lla", place}}});
}

TEST_CASE("an OpenSfM scene's place on the Earth is in exports in its axes, and its unit in pages") {
  const TemporaryFolder folder;
  write_as_opensfm(folder.path());
  const std::string model = (folder / "model").string();
  const Outcome built = lumatlas_here({"build", folder.path().string(), "-o", model, "--hold", "4", "--quiet"});
  INFO(built.err);
  REQUIRE(built.status == 0);
  const auto exported = [&](const std::string& form, const std::string& name, const Arguments& more) {
    Arguments arguments{"export", model, "--to", form, "-o", (folder / name).string(), "--json", "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = lumatlas_here(arguments);
    REQUIRE(outcome.status == 0);
    return json::parse(outcome.out)["georeference"];
  };
  CHECK(exported("gltf", "placed", {"--as-scene"}) == kPlace);
  const json document = json::parse(bytes_of(folder / "placed" / "scene.gltf"));
  CHECK(document["nodes"][0]["extras"]["georeference"] == kPlace);
  CHECK(exported("obj", "obj", {"--as-scene"}) == kPlace);
  CHECK_THAT(bytes_of(folder / "obj" / "scene.obj").substr(0, 300),
             Catch::Contains("# Coordinates are metres east, north and up of latitude 48.25, longitude -2.125 and "
                             "altitude 130.5 (WGS 84)\n"));
  CHECK(exported("gltf", "upright", {}).is_null());
  const json upright = json::parse(bytes_of(folder / "upright" / "scene.gltf"))["nodes"][0];
  CHECK_FALSE(upright.value("extras", json::object()).contains("georeference"));
  (void)exported("web", "page", {});
  CHECK_THAT(bytes_of(folder / "page" / "index.html"), Catch::Contains(" data-unit=\"m\""));
}

TEST_CASE("a scene's place on the Earth is in its model, by the option before the file beside the scene") {
  const TemporaryFolder folder;
  const fs::path scene = folder / "scene";
  fs::copy(made().scene, scene, fs::copy_options::recursive);
  std::ofstream(scene / "reference_lla.json") << R"({"latitude": -33.5, "longitude": 151.25, "altitude": 20})";
  const auto place_in = [&](const std::string& name, const Arguments& more) {
    const std::string model = (folder / name).string();
    Arguments arguments{"build", scene.string(), "-o", model, "--max-views", "2", "--texture", "none"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome built = lumatlas_here(arguments);
    INFO(built.err);
    REQUIRE(built.status == 0);
    CHECK_THAT(built.err, Catch::Contains("its coordinates are metres east, north and up of latitude"));
    const Outcome inspected = lumatlas_here({"inspect", model, "--json"});
    REQUIRE(inspected.status == 0);
    const Outcome as_text = lumatlas_here({"inspect", model});
    CHECK_THAT(as_text.out, Catch::Contains("on Earth   the middle at latitude "));
    return json::parse(inspected.out)["georeference"];
  };
  const json by_file = place_in("by_file", {});
  CHECK(by_file["latitude"] == -33.5);
  CHECK(by_file["middle"]["longitude"].get<double>() == Approx(151.25).margin(1e-3));
  const json by_option = place_in("by_option.glb", {"--georeference", "48.25,-2.125,130.5"});
  CHECK(by_option["longitude"] == -2.125);
  CHECK(by_option["middle"]["latitude"].get<double>() == Approx(48.25).margin(1e-3));
  const std::string bad = (folder / "bad").string();
  const Outcome refused = lumatlas_here({"build", scene.string(), "-o", bad, "--georeference", "100,0,0"});
  CHECK(refused.status == 2);
  CHECK_THAT(refused.err, Catch::Contains("100,0,0 has a latitude beyond 90 degrees"));
  std::ofstream(scene / "reference_lla.json") << "{}";
  const Outcome damaged = lumatlas_here({"build", scene.string(), "-o", bad});
  CHECK(damaged.status == 1);
  CHECK_THAT(damaged.err, Catch::Contains("reference_lla.json: "));
  CHECK_FALSE(fs::exists(bad));
}

}  // namespace
}  // namespace lumatlas
