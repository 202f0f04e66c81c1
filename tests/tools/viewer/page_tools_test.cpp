// SPDX-License-Identifier: GPL-3.0-or-later
// The tools of the page: comparing with photographs, measuring.
#include <catch2/catch.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/viewer/browser.h"
#include "tests/tools/viewer/test_site.h"

namespace lumatlas {
namespace {

// Opens the page of one part of the test. Returns what it said; nothing where there is no browser.
Said said_by_tools(const std::string& part) {
  std::vector<SiteFile> files = site_files();
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

}  // namespace
}  // namespace lumatlas
