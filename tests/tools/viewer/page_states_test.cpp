// SPDX-License-Identifier: GPL-3.0-or-later
// The page when the GPU is lost, while it waits, on a slow GPU, and at the ends of movements.
#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/scenes/small_scenes.h"
#include "tests/tools/viewer/browser.h"
#include "tests/tools/viewer/test_site.h"

namespace lumatlas {
namespace {

// The site, one of three views in few/, a page in waits/ that waits for a model, and the test's page.
std::vector<SiteFile> states_and_test() {
  std::vector<SiteFile> files = site_files();
  for (const SiteFile& file : site_files(room_snapshot(3, {}, {16, 2, 0}))) files.push_back(in_folder("few", file));
  for (const SiteFile& file : page_files("waits", {.live = true})) files.push_back(in_folder("waits", file));
  files.push_back(text_file("waits/live.json", "application/json", R"({"version": 0, "last": false})"));
  files.push_back(cameras_file());
  for (SiteFile& file : test_page_files("page_states_test.html")) files.push_back(std::move(file));
  return files;
}

// Opens the page of one part of the test, and checks what it said: each name with its value. Whatever else it said is
// returned; nothing where there is no browser.
Said checked_part(const std::string& part, const Said& expected) {
  Said said = said_in_browser(states_and_test(), "/test.html#" + part);
  if (said.empty()) return said;
  CHECK(problem_of(said) == "");
  for (const auto& [name, value] : expected) {
    CAPTURE(name);
    REQUIRE(said.contains(name));
    CHECK(said.at(name) == value);
  }
  return said;
}

TEST_CASE("a page whose GPU is lost shows the same picture once it is back") {
  const Said said = checked_part("lost", {{"drawn-while-lost", "false"},
                                          {"back", "4 of 4 pictures alike"},
                                          {"told-back", "false"},
                                          {"lost-while-loading", "4 of 4 pictures alike"}});
  if (said.empty()) return;
  CHECK_THAT(said.at("told"), Catch::StartsWith("true The browser has taken the GPU away."));
}

TEST_CASE("pages of other sizes leave nothing on the GPU, nor does a page that is closed") {
  const Said said = checked_part("objects", {{"left-by-resizes", "0"}, {"closed", "0"}});
  if (said.empty()) return;
  CHECK(std::stoi(said.at("made")) > 100);
}

TEST_CASE("buttons of a page that waits for a model do nothing, and say so") {
  checked_part("waits", {{"waiting", "first-view hold link more save walk"}, {"help", "true"}});
}

TEST_CASE("other pages open a model by one call, and a jump's last frame is drawn") {
  checked_part("opens", {{"opened", "12"}, {"end-of-jump", "true"}});
}

TEST_CASE("clustered faces are few, cover the same, and keep the border to other pieces") {
  checked_part("clusters", {{"fewer", "true"}, {"border", "true"}, {"area", "1.0000 0"}, {"little", "3 0 3"}});
}

TEST_CASE("a slow GPU draws drafts until it draws them whole in time, and they are like other frames") {
  const Said said = checked_part("drafts", {{"states",
                                             "full 0.5 slow, draft 0.2 slow, draft 0.3 slow, full 1.0, draft 0.2 slow, "
                                             "draft 0.8 slow, draft 0.8 slow"},
                                            {"first-whole", "400x300"},
                                            {"same-states", "true"},
                                            {"fewer-faces", "true"},
                                            {"whole-alone", "true false"}});
  if (said.empty()) return;
  REQUIRE(said.contains("like-full"));
  const double psnr = std::stod(said.at("like-full"));  // dB
  CHECK(psnr > 30);
  CHECK(psnr < 80);  // it is another program
}

TEST_CASE("on a slow GPU a still frame becomes sharp part by part, although photographs come") {
  const Said said = checked_part("still", {{"partly", "true"}, {"frames-go-on", "true"}, {"kept", "true"}});
  if (said.empty()) return;
  REQUIRE(said.contains("sharp"));
  CHECK(std::stod(said.at("sharp")) > 45);  // dB against the whole picture
}

TEST_CASE("with three photographs the camera comes back to them, and rests there") {
  checked_part("few", {{"away", "true"}, {"back", "true"}, {"rests", "true"}});
}

}  // namespace
}  // namespace lumatlas
