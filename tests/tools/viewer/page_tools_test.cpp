// SPDX-License-Identifier: GPL-3.0-or-later
// The tools of the page: comparing with photographs, measuring, camera paths, gamepads, walking.
#include <catch2/catch.hpp>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/temporary_folder.h"
#include "tests/tools/viewer/browser.h"
#include "tests/tools/viewer/test_site.h"
#include "tools/picture/paths/camera_path.h"
#include "tools/picture/paths/path_file.h"

namespace lumatlas {
namespace {

// The small model, whose input has other coordinates.
Snapshot moved_model(const glm::dvec3& offset) {
  Snapshot model = site_model();
  auto surface = std::make_shared<Surface>(*model.surface);
  surface->offset = offset;
  model.surface = std::move(surface);
  return model;
}

// Opens the page of one part of the test. Returns what it said; nothing where there is no browser.
Said said_by_tools(const std::string& part, const Snapshot& model = site_model()) {
  std::vector<SiteFile> files = site_files(model);
  for (SiteFile& file : test_page_files("page_tools_test.html")) files.push_back(std::move(file));
  Said said = said_in_browser(files, "/test.html#" + part);
  CHECK(problem_of(said) == "");
  return said;
}

TEST_CASE("a divider stands between a photograph and the model's picture of its camera") {
  const Said said = said_by_tools("compares");
  if (said.empty()) return;
  REQUIRE(said.contains("in-part"));
  CHECK(said.at("offered") == "true");
  CHECK(said.at("focused") == "divider");
  CHECK(said.at("photograph") == "0 1.00");
  CHECK(std::stod(said.at("lies")) <= 1);  // CSS pixels
  CHECK(said.at("keys") == "50 48 58 100 100 0");
  CHECK(said.at("dragged") == "25 0 75 0");
  CHECK(said.at("escaped") == "true picture");
  CHECK(said.at("left") == "true");
  CHECK(said.at("another") == "0 1.00");
  CHECK(said.at("in-part") == "0 0.96");  // a tile of 16 x 16 pixels of 96 x 72
}

TEST_CASE("a distance between two points has the surface's deviation, and its marks follow the camera") {
  const Said said = said_by_tools("measures");
  if (said.empty()) return;
  REQUIRE(said.contains("closed"));
  CHECK(said.at("asks") == "Click a point of the surface. picture");
  CHECK(said.at("asks-again") == "Click a second point.");
  INFO(said.at("measured"));
  CHECK(said.at("right") == "true scene units");
  std::istringstream deviations(said.at("deviation"));
  double shown = 0, expected = 0;
  deviations >> shown >> expected;
  CHECK(expected > 0.2);  // cells deviate by 0, 0.3 and 0.6
  CHECK(shown == Approx(expected).epsilon(0.05));
  CHECK(said.at("depths") == "true true");
  CHECK(said.at("marks") == "150,140 260,160");
  CHECK(said.at("line") == "true");
  CHECK(said.at("visible") == "false");
  CHECK(said.at("hidden") == "true");
  CHECK(said.at("third") == "Click a second point. 1");
  CHECK(said.at("dragged") == "1");
  CHECK(said.at("entered") == "2");
  CHECK(said.at("nothing") == "There is no surface. 2");
  CHECK(said.at("cleared") == "Click a point of the surface. 0");
  CHECK(said.at("closed") == "true false ");
}

TEST_CASE("a gamepad moves and turns the camera, and a link to the view is copied") {
  const Said said = said_by_tools("plays");
  if (said.empty()) return;
  REQUIRE(said.contains("copied"));
  CHECK(said.at("moves") == "0,0,1 false | 1,0,0 false | 0,0,0 true | 0,1,0 false");
  CHECK(said.at("rests") == "true");
  CHECK(said.at("copied") == "true");
}

TEST_CASE("a visitor who walks stays at eye height and stops before a wall") {
  const Said said = said_by_tools("walks");
  if (said.empty()) return;
  REQUIRE(said.contains("ends"));
  CHECK(said.at("begins") == "true false true");
  CHECK(said.at("stops") == "true true true true");
  CHECK(said.at("height") == "true");
  CHECK(said.at("ends") == "true");
}

TEST_CASE("a camera's path that the page plays is the one that `render --path` reads from its file") {
  const glm::dvec3 offset(100, -200, 300);
  const Said said = said_by_tools("flies", moved_model(offset));
  if (said.empty()) return;
  REQUIRE(said.contains("closed"));
  CHECK(said.at("nothing") == "true true 0 key frames, 0 seconds");
  CHECK(said.at("ordered") == "63.74 75.18 51.77");  // across 4:3, of 50, 60 and 40 degrees
  CHECK(said.at("bad-time") == "It must be 0.1 to 3600 seconds. 2");
  CHECK(said.at("status") == "3 key frames, 2.7 seconds");
  CHECK(said.at("deleted") == "3");
  CHECK(said.at("went") == "0.000000");
  CHECK(said.at("ended") == "Play");
  CHECK(said.at("plays") == "Stop");
  CHECK(said.at("touched") == "Play");
  CHECK(said.at("closed") == "true true");

  const TemporaryFolder folder;
  PathDefaults defaults;
  defaults.offset = offset;
  const CameraPath path(read_path(folder.with_file("path.json", said.at("path")), defaults));
  CHECK(path.end() == Approx(2.7));
  std::istringstream flown(said.at("flown"));
  for (const Vantage& vantage : path.evenly(9)) {
    glm::dvec3 position;
    glm::dmat3 rotation;  // by rows
    double fov_deg = 0;
    flown >> position.x >> position.y >> position.z;
    for (int row = 0; row < 3; ++row) flown >> rotation[0][row] >> rotation[1][row] >> rotation[2][row];
    flown >> fov_deg;
    REQUIRE(flown);
    CHECK(glm::distance(position, vantage.position) < 1e-6);
    const glm::dmat3 expected = glm::mat3_cast(vantage.cam_from_world);
    for (int column = 0; column < 3; ++column) CHECK(glm::distance(rotation[column], expected[column]) < 1e-6);
    CHECK(fov_deg == Approx(vantage.fov_deg).epsilon(1e-6));
  }
}

}  // namespace
}  // namespace lumatlas
