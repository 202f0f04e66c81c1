// SPDX-License-Identifier: GPL-3.0-or-later
// The owner's file beside a model: where it stands, how it is served, what the page shows of it, and how it is edited.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/viewer/browser.h"
#include "tests/tools/viewer/test_site.h"
#include "tools/viewer/page_file.h"

namespace lumatlas {
namespace {

constexpr const char* kOwnersFile = R"({
 "title": "A room", "description": "Of the test.", "up": [0, 0, 2],
 "view": {"position": [2, 2.5, 1.25], "turned": [0.5, 0.5, -0.5, 0.5], "fov": 55},
 "unit": {"name": "m", "length": 2},
 "annotations": [
  {"point": [4, 2.5, 1.25], "title": "Wall", "text": "A wall.",
   "view": {"position": [1.5, 2.5, 1.25], "turned": [0.5, 0.5, -0.5, 0.5], "fov": 60}},
  {"point": [40, 2.5, 1.25], "title": "Far"}
 ]
})";

// The site with an owner's file, without one in plain/, and with one that is wrong in bad/.
std::vector<SiteFile> owners_sites(const std::string& part) {
  std::vector<SiteFile> files;
  SiteOptions options;
  options.photographs.format = ImageFormat::png;
  const std::string folder = part == "shows" ? "" : part == "edits" ? "plain/" : "bad/";
  if (part == "shows") options.page_file = kOwnersFile;
  if (part == "bad") options.page_file = R"({"annotations": [{"point": [0, 0, 0], "txt": "x"}]})";
  write_site(site_model(), options, [&](SiteFile file) {
    file.name.insert(0, folder);
    files.push_back(std::move(file));
  });
  for (SiteFile& file : test_page_files("owner_page_test.html")) files.push_back(std::move(file));
  return files;
}

Said said_of_owner(const std::string& part) {
  Said said = said_in_browser(owners_sites(part), "/test.html#" + part);
  CHECK(problem_of(said) == "");
  return said;
}

TEST_CASE("the page shows what its owner says: title, first view, annotations, a part of the surface") {
  const Said said = said_of_owner("shows");
  if (said.empty()) return;
  REQUIRE(said.contains("own"));
  CHECK(said.at("title") == "A room: A room true");
  CHECK(said.at("first-view") == "0.000000 55");
  CHECK(said.at("up") == "0.00 0.00 1.00");
  CHECK(said.at("unit") == R"({"name":"m","length":2})");
  CHECK(said.at("about") == "Of the test. | WallFar");
  CHECK(said.at("labels") == "Annotation 1: Wall, Annotation 2: Far");
  CHECK(said.at("opened") == "Wall | A wall. | 1 of 2 | annotation-close");
  CHECK(said.at("flown") == "0.000000");
  CHECK(said.at("looks-there") == "1.0000 true");
  CHECK(said.at("closed") == "true");
  CHECK(said.at("first-again") == "0.000000 55");
  CHECK(said.at("cropped") == "true true true true");
  CHECK(said.at("groups") == "true");
}

TEST_CASE("an owner edits the page, saves the file, and reads it again") {
  const Said said = said_of_owner("edits");
  if (said.empty()) return;
  REQUIRE(said.contains("hidden-share"));
  CHECK(said.at("uncluttered") == "true true true");
  CHECK(said.at("no-help") == "false");
  CHECK(said.at("bad-unit") == "The length of a scene unit must be a number above 0. null");
  CHECK(said.at("asks") == "Click the point of the surface that you want to annotate.");
  CHECK(said.at("annotated") == "1 false Annotation 1");
  CHECK(said.at("ordered") == "Annotation 2, The wall");
  CHECK(said.at("hidden") == "1 true");
  CHECK(said.at("crop") == "0.75 0.60 1.00");
  CHECK(said.at("saved") == "page.json application/json");
  const nlohmann::json file = nlohmann::json::parse(said.at("file"));
  CHECK(file["title"] == "A <b>room</b>");
  CHECK(file["description"] == "Two lines\nof text");
  CHECK(file["unit"] == nlohmann::json{{"name", "m"}, {"length", 2.5}});
  CHECK(file["annotations"][1]["text"] == "It is \"white\".");
  CHECK(said.at("read-again") == "true true");
  CHECK(said.at("sliders") == "50 120 20");
  CHECK(said.at("same-box") == "true");
  CHECK(said.at("refused") ==
        "page.json: it is not JSON.\n"
        "page.json: it must be an object.\n"
        "page.json: it has the unknown field \"titel\".\n"
        "page.json: title must be a text of at most 200 characters.\n"
        "page.json: view.turned must be 4 numbers from -1000000000 to 1000000000.\n"
        "page.json: up must be more than zero long.\n"
        "page.json: annotations[0].point must be 3 numbers from -1000000000 to 1000000000.\n"
        "page.json: hidden[0].radius must be a number from 0 to 1000000000.\n"
        "page.json: crop.size must be 3 numbers from 0 to 1000000000.\n"
        "page.json: unit.length must be a number from 1e-9 to 1000000000.\n"
        "page.json: annotations must be a list of at most 200 entries.");
}

TEST_CASE("a page whose owner's file is wrong says where, and shows the model") {
  const Said said = said_of_owner("bad");
  if (said.empty()) return;
  REQUIRE(said.contains("complaint"));
  CHECK(said.at("complaint") == "false page.json: annotations[0] has the unknown field \"txt\". complete");
}

TEST_CASE("the owner's file stands beside the model, under its name") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "fox");
  const std::filesystem::path file = folder / "fox.page.json";
  CHECK(page_file_of(folder / "fox") == file);
  CHECK(page_file_of(folder / "fox/") == file);
  CHECK(page_file_of(folder / "fox.glb") == file);
  CHECK(read_page_file(folder / "fox").empty());
  (void)folder.with_file("fox.page.json", R"({"title": "Fox"})");
  CHECK(nlohmann::json::parse(read_page_file(folder / "fox"))["title"] == "Fox");
  (void)folder.with_file("fox.page.json", "{");
  CHECK_THROWS_AS(read_page_file(folder / "fox"), InputError);
  (void)folder.with_file("fox.page.json", "[]");
  CHECK_THROWS_WITH(read_page_file(folder / "fox"), Catch::EndsWith("fox.page.json: must be an object"));
}

TEST_CASE("one file has the owner's file inside") {
  SiteOptions options;
  options.page_file = kOwnersFile;
  std::ostringstream page;
  write_one_page(page, site_model(), options);
  CHECK(page.str().find("data-file=\"page.json\"") != std::string::npos);
  CHECK(page.str().find(" data-page-file=\"page.json\"") != std::string::npos);
}

}  // namespace
}  // namespace lumatlas
