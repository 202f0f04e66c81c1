// SPDX-License-Identifier: GPL-3.0-or-later
// What becomes of the page where the GPU is lost, while it waits, where the GPU is slow, and at the ends of movements.
#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/small_scenes.h"
#include "tests/tools/viewer/browser.h"
#include "tests/tools/viewer/test_site.h"

namespace lumatlas {
namespace {

// The site, one of three views in few/, a page in waits/ that waits for a model, and the test's page.
std::vector<SiteFile> states_and_test() {
  std::vector<SiteFile> files = site_files();
  for (const SiteFile& file : site_files(room_snapshot(3, {}, {16, 2, 0}))) files.push_back(in_folder("few", file));
  SiteOptions options;
  options.live = true;
  for (const SiteFile& file : page_files(options)) files.push_back(in_folder("waits", file));
  files.push_back(text_file("waits/live.json", "application/json", R"({"version": 0, "last": false})"));
  files.push_back(cameras_file());
  for (SiteFile& file : test_page_files("page_states_test.html")) files.push_back(std::move(file));
  return files;
}

Said said_by_part(const std::string& part) {
  const Said said = said_in_browser(states_and_test(), "/test.html#" + part);
  if (!said.empty()) CHECK((said.contains("problem") ? said.at("problem") : "") == "");
  return said;
}

TEST_CASE("a page whose GPU is lost shows the same picture once it is back") {
  const Said said = said_by_part("lost");
  if (said.empty()) return;
  REQUIRE(said.contains("lost-while-loading"));
  CHECK_THAT(said.at("told"), Catch::StartsWith("true The browser has taken the GPU away."));
  CHECK(said.at("drawn-while-lost") == "false");
  CHECK(said.at("back") == "4 of 4 pictures alike");
  CHECK(said.at("told-back") == "false");
  CHECK(said.at("lost-while-loading") == "4 of 4 pictures alike");
}

TEST_CASE("pages of other sizes leave nothing on the GPU, nor does a page that is closed") {
  const Said said = said_by_part("objects");
  if (said.empty()) return;
  REQUIRE(said.contains("closed"));
  CHECK(std::stoi(said.at("made")) > 100);
  CHECK(said.at("left-by-resizes") == "0");
  CHECK(said.at("closed") == "0");
}

TEST_CASE("buttons of a page that waits for a model do nothing, and say so") {
  const Said said = said_by_part("waits");
  if (said.empty()) return;
  REQUIRE(said.contains("waiting"));
  CHECK(said.at("waiting") == "hold save walk");
  CHECK(said.at("help") == "true");
}

TEST_CASE("other pages open a model by one call, and a jump's last frame is drawn") {
  const Said said = said_by_part("opens");
  if (said.empty()) return;
  REQUIRE(said.contains("end-of-jump"));
  CHECK(said.at("opened") == "12");
  CHECK(said.at("end-of-jump") == "true");
}

TEST_CASE("on a slow GPU a still frame becomes sharp part by part, although photographs come") {
  const Said said = said_by_part("still");
  if (said.empty()) return;
  REQUIRE(said.contains("sharp"));
  CHECK(said.at("partly") == "true");
  CHECK(said.at("frames-go-on") == "true");
  CHECK(said.at("kept") == "true");
  CHECK(std::stod(said.at("sharp")) > 45);  // dB against the whole picture
}

TEST_CASE("with three photographs the camera comes back to them, and rests there") {
  const Said said = said_by_part("few");
  if (said.empty()) return;
  REQUIRE(said.contains("rests"));
  CHECK(said.at("away") == "true");
  CHECK(said.at("back") == "true");
  CHECK(said.at("rests") == "true");
}

}  // namespace
}  // namespace lumatlas
