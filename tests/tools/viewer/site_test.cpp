// SPDX-License-Identifier: GPL-3.0-or-later
// The files of a site: their names, and what the names promise.
#include "tools/viewer/site.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "atlas/model/content_digest.h"
#include "atlas/model/model_file.h"
#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/view_parts.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

using nlohmann::json;
using Files = std::map<std::string, std::vector<std::uint8_t>>;

Snapshot small_room() {
  return room_snapshot(3, {}, {16, 2, 0});
}

Files files_of_site(const Snapshot& snapshot, const std::string& title) {
  Files files;
  SiteOptions options;
  options.title = title;
  write_site(snapshot, options, [&](SiteFile file) {
    INFO(file.name);
    CHECK(files.emplace(file.name, std::move(file.bytes)).second);
  });
  return files;
}

// All texts in a JSON value.
void collect_texts(const json& value, std::set<std::string>& texts) {
  if (value.is_string()) texts.insert(value.get<std::string>());
  if (value.is_structured()) {
    for (const json& part : value) collect_texts(part, texts);
  }
}

bool is_named_by_content(const std::string& name) {
  return std::regex_search(name, std::regex("-[0-9a-f]{16}\\.[a-z]+$"));
}

// Names that index.html or tileset.json give to files named by content.
std::set<std::string> names_given(const Files& files) {
  std::set<std::string> names;
  collect_texts(json::parse(files.at("tileset.json")), names);
  const std::string html(files.at("index.html").begin(), files.at("index.html").end());
  const std::regex attribute("\"([^\"]*)\"");
  for (std::sregex_iterator found(html.begin(), html.end(), attribute), end; found != end; ++found) {
    names.insert((*found)[1]);
  }
  std::erase_if(names, [](const std::string& name) { return !is_named_by_content(name); });
  return names;
}

TEST_CASE("a site's files are named by what they hold, and index.html and tileset.json name them all") {
  const Files files = files_of_site(small_room(), "room");
  std::set<std::string> tagged;
  for (const auto& [name, bytes] : files) {
    INFO(name);
    if (!is_named_by_content(name)) continue;
    CHECK(name.find('-' + content_digits(std::as_bytes(std::span(bytes))) + '.') != std::string::npos);
    tagged.insert(name);
  }
  CHECK(tagged.size() == files.size() - 4);
  for (const char* name : {"index.html", "tileset.json", "viewer.js", "shaders.json"}) CHECK(files.contains(name));
  CHECK(names_given(files) == tagged);
  CHECK(tagged.size() >= 3 + 2 + 3 * 3);  // page; poster, surface; three files a view
}

TEST_CASE("a site's page shows the poster before its script is there; pages that do not know its name wait for it") {
  const Files files = files_of_site(small_room(), "room");
  const auto text = [](const std::vector<std::uint8_t>& bytes) { return std::string(bytes.begin(), bytes.end()); };
  const auto poster = std::find_if(files.begin(), files.end(),
                                   [](const auto& file) { return file.first.find("poster-") != std::string::npos; });
  REQUIRE(poster != files.end());
  const std::string start = "<img id=\"poster\" alt=\"\" fetchpriority=\"high\" ";
  CHECK_THAT(text(files.at("index.html")), Catch::Contains(start + "src=\"" + poster->first + "\">"));
  CHECK_THAT(text(page_files("room").front().bytes), Catch::Contains(start + "hidden>"));
  std::ostringstream page;
  write_one_page(page, small_room(), {});
  CHECK_THAT(page.str(), Catch::Contains(start + "hidden>"));
}

TEST_CASE("no name of a site means one thing in one version and another in the next") {
  const Snapshot first = small_room();
  Snapshot second = first;
  auto other = std::make_shared<StoredView>(*first.views[1]);
  change_colors(*other, [](std::uint8_t value) { return value ^ 0x40; });
  second.views[1] = other;
  auto surface = std::make_shared<Surface>(*first.surface);
  surface->mesh.positions.front() += glm::vec3(0.01F);
  second.surface = surface;
  const Files before = files_of_site(first, "room"), after = files_of_site(second, "room");
  std::size_t alike = 0;
  for (const auto& [name, bytes] : before) {
    INFO(name);
    const auto found = after.find(name);
    if (found == after.end() || name == "tileset.json") continue;
    CHECK(found->second == bytes);
    ++alike;
  }
  CHECK(alike > 0);
  const json scene = json::parse(before.at("tileset.json")), next = json::parse(after.at("tileset.json"));
  CHECK(next["root"]["content"]["uri"] != scene["root"]["content"]["uri"]);
  const auto photograph = [](const json& tileset, std::size_t view) {
    const json& properties = tileset["extensions"]["LUMATLAS_lumigraph"];
    return properties["images"][properties["views"][view]["image"].get<std::size_t>()]["uri"];
  };
  CHECK(photograph(next, 1) != photograph(scene, 1));
  CHECK(photograph(next, 2) == photograph(scene, 2));
}

TEST_CASE("a site is a model that reads back as what was exported, up to what makes it small") {
  const Snapshot model = small_room();
  const TemporaryFolder folder;
  SiteOptions options;
  options.photographs.format = ImageFormat::png;
  write_site_folder(folder.path(), model, options);
  const Snapshot read = read_model(folder.path()).snapshot;
  CHECK(read.references.offsets == model.references.offsets);
  CHECK(read.references.views == model.references.views);
  CHECK(read.surface->mesh.faces.size() == model.surface->mesh.faces.size());
  REQUIRE(read.views.size() == model.views.size());
  const Bounds before = bounds(model.surface->mesh), after = bounds(read.surface->mesh);
  CHECK(glm::distance(before.min, after.min) + glm::distance(before.max, after.max) < 1e-2);
  for (std::size_t view = 0; view < read.views.size(); ++view) {
    CHECK(read.views[view]->camera.fx == model.views[view]->camera.fx);
  }
}

TEST_CASE("a title that looks like a place in the page's template stays a title") {
  SiteOptions options;
  options.title = "a{{data}}b{{script}}{{style}}{{title}}{{x";
  std::ostringstream page;
  write_one_page(page, small_room(), options);
  const std::string html = page.str();
  CHECK(html.find("<title>" + options.title + "</title>") != std::string::npos);
  // The data stands in the body, where the page looks for it, and the page's script after it.
  const std::size_t first = html.find("<script type=\"application/octet-stream\"");
  REQUIRE(first != std::string::npos);
  CHECK(first > html.find("<main>"));
  CHECK(html.find("<script type=\"module\">") > html.rfind("<script type=\"application/octet-stream\""));
  const std::vector<std::uint8_t> index = page_files(options.title).front().bytes;
  CHECK(std::string(index.begin(), index.end()).find("<title>" + options.title + "</title>") != std::string::npos);
}

}  // namespace
}  // namespace lumatlas
