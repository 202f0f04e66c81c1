// SPDX-License-Identifier: GPL-3.0-or-later
// The page where the network is bad: it shows in the end what it shows where the network is good; what is never to be
// had it replaces, and tells so in one line.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <glm/vec3.hpp>
#include <iterator>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/viewer/browser.h"
#include "tests/tools/viewer/test_site.h"

namespace lumatlas {
namespace {

using nlohmann::json;
using Kind = Trouble::Kind;

// The file that the page fetches once it has seen what is shown while something is missing.
const std::string kMended = "mended";

// The site in "good/" and in the other folders, and a test's page.
std::vector<SiteFile> sites_and_test(const std::string& html, const std::vector<std::string>& folders) {
  std::vector<SiteFile> files = test_page_files(html);
  files.push_back(cameras_file());
  files.push_back(text_file(kMended, "text/plain", "mended"));
  for (const SiteFile& file : site_files()) {
    files.push_back(in_folder("good", file));
    for (const std::string& folder : folders) files.push_back(in_folder(folder, file));
  }
  return files;
}

SiteFile& file_named(std::vector<SiteFile>& files, const std::string& name) {
  for (SiteFile& file : files) {
    if (file.name == name) return file;
  }
  throw std::logic_error("no file " + name);
}

json parsed(const SiteFile& file) {
  return json::parse(file.bytes);
}

void store(SiteFile& file, const json& value) {
  const std::string text = value.dump();
  file.bytes.assign(text.begin(), text.end());
}

// The name of a view's photograph.
std::string image_of(const json& tileset, std::size_t view) {
  const json& properties = tileset["extensions"]["LUMATLAS_lumigraph"];
  return properties["images"][properties["views"][view]["image"].get<std::size_t>()]["uri"];
}

// Files that the browser itself fetches when a page is opened; the page cannot fetch them again.
bool is_opened_by_browser(const std::string& name) {
  return name.ends_with(".html") || name.ends_with(".js") || name.ends_with(".css");
}

TEST_CASE("a page shows the same picture on a network that refuses, delays and cuts short") {
  // How many of five requests in a row for a file meet trouble, up to three, goes round from file to file. Five tries
  // then bring each file, in whatever order the browser asks for files.
  std::mutex mutex;
  std::map<std::string, int> numbers, asked;
  int troubled = 0;
  const Network network = [&](const std::string& name) -> Trouble {
    if (!name.starts_with("bad/") || is_opened_by_browser(name)) return {};
    const std::lock_guard lock(mutex);
    const int number = numbers.try_emplace(name, static_cast<int>(numbers.size())).first->second;
    const int request = asked[name]++;
    const std::chrono::milliseconds delay((number + request) % 4 * 40);
    if (request % 5 >= number % 4) return {Kind::none, delay};
    constexpr Kind kKinds[] = {Kind::refused, Kind::cut, Kind::shortened};
    return {kKinds[troubled++ % 3], delay};
  };
  const Said said = said_in_browser(sites_and_test("network_test.html", {"bad"}), "/test.html#bad", network);
  if (said.empty()) return;
  CHECK(problem_of(said) == "");
  CHECK(troubled > 10);
  REQUIRE(said.contains("page"));
  CHECK(said.at("viewer") == "4 of 4 pictures alike, missing: ");
  CHECK(said.at("page") == "complete 12/12, 12 thumbnails of 12, missing: ");
}

TEST_CASE("what is never to be had is replaced by the next best, and told") {
  std::vector<SiteFile> files = sites_and_test("network_test.html", {"view", "fine"});
  // Small models have no coarse mesh of their own.
  SiteFile& manifest = file_named(files, "fine/tileset.json");
  json tileset = parsed(manifest);
  json surface = tileset["root"];
  tileset["root"]["content"]["uri"] = "coarse.glb";
  tileset["root"]["children"] = {surface};
  store(manifest, tileset);
  const std::string fine = "fine/" + surface["content"]["uri"].get<std::string>();
  SiteFile coarse = file_named(files, fine);
  coarse.name = "fine/coarse.glb";
  files.push_back(coarse);
  const std::string view = "view/" + image_of(parsed(file_named(files, "view/tileset.json")), 3);
  const std::map<std::string, Trouble> troubles{{view, {Kind::missing, {}}}, {fine, {Kind::refused, {}}}};
  std::mutex mutex;
  bool is_mended = false;
  const Network network = [&](const std::string& name) -> Trouble {
    const std::lock_guard lock(mutex);
    if (name == kMended) is_mended = true;
    const auto found = troubles.find(name);
    // The fine mesh can be had in the end.
    return found == troubles.end() || (name != view && is_mended) ? Trouble{} : found->second;
  };
  const Said said = said_in_browser(files, "/test.html#missing", network);
  if (said.empty()) return;
  CHECK(problem_of(said) == "");
  REQUIRE(said.contains("fine-later"));
  const std::string end = ". What is there is shown, and the page tries again.";
  CHECK(said.at("view-line") ==
        "1 photograph is missing: " + view.substr(5) + " cannot be loaded: the server says 404" + end);
  CHECK(said.at("view-page") == "complete 11/12, true true");  // its line is seen, and so are the buttons
  CHECK(std::stod(said.at("view-psnr")) > 12);  // the photographs of this room disagree; black would be 7 dB
  CHECK(said.at("fine-line") ==
        "The fine mesh is missing: " + fine.substr(5) + " cannot be loaded: the server says 503" + end);
  CHECK(std::stod(said.at("fine-psnr")) > 45);  // of averaged colours
  CHECK(said.at("fine-later") == "4 of 4 pictures alike, missing: ");
}

// The site of the same model in `kManyChunks` or more.
constexpr std::size_t kManyChunks = 10;
std::vector<SiteFile> site_in_chunks(std::size_t listed_views = SiteOptions{}.listed_views) {
  for (std::size_t faces = 1000;; faces = faces * 3 / 4) {
    std::vector<SiteFile> files = site_files(site_model(), faces, 2 * faces, listed_views);
    const auto is_surface = [](const SiteFile& file) { return file.name.starts_with("surface-"); };
    if (static_cast<std::size_t>(std::count_if(files.begin(), files.end(), is_surface)) >= kManyChunks) return files;
  }
}

// How far a box is from a point, and then its middle.
std::pair<double, double> distance_to_box(const json& box, const glm::dvec3& point) {
  double outside = 0, middle = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto number = static_cast<std::size_t>(axis);
    const auto least = box[number].get<double>(), most = box[number + 3].get<double>();
    const double beyond = std::max({least - point[axis], point[axis] - most, 0.0});
    outside += beyond * beyond;
    middle += (0.5 * (least + most) - point[axis]) * (0.5 * (least + most) - point[axis]);
  }
  return {outside, middle};
}

// The tiles without children below a tile, which are its chunks.
std::vector<json> chunks_below(const json& tile) {
  if (!tile.contains("children")) return {tile};
  std::vector<json> chunks;
  for (const json& child : tile["children"]) {
    for (json& chunk : chunks_below(child)) chunks.push_back(std::move(chunk));
  }
  return chunks;
}

// The chunks of a tileset in the order in which a visitor needs them, who begins at the first view.
std::vector<std::string> chunks_by_distance(const json& tileset) {
  const json& properties = tileset["extensions"]["LUMATLAS_lumigraph"];
  const json& view = properties["views"][properties["firstView"].get<std::size_t>()];
  glm::dvec3 center(0);
  for (std::size_t row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      center[column] -= view["rotation"][3 * row + static_cast<std::size_t>(column)].get<double>() *
                        view["translation"][row].get<double>();
    }
  }
  std::vector<std::pair<std::pair<double, double>, std::string>> chunks;
  for (const json& tile : chunks_below(tileset["root"])) {
    const json& content = tile["content"];
    chunks.emplace_back(distance_to_box(content["extras"]["box"], center), content["uri"]);
  }
  std::sort(chunks.begin(), chunks.end());
  std::vector<std::string> names;
  for (const auto& [distance, name] : chunks) names.push_back(name);
  return names;
}

// Gives the site in a folder the good site's surface as its coarse one, and returns the site's tileset.
json with_coarse_surface(std::vector<SiteFile>& files, const std::string& folder) {
  const json good = parsed(file_named(files, "good/tileset.json"));
  SiteFile coarse = file_named(files, "good/" + good["root"]["content"]["uri"].get<std::string>());
  coarse.name = folder + "/coarse.glb";
  files.push_back(std::move(coarse));
  SiteFile& manifest = file_named(files, folder + "/tileset.json");
  json tileset = parsed(manifest);
  tileset["root"]["content"] = good["root"]["content"];
  tileset["root"]["content"]["uri"] = "coarse.glb";
  store(manifest, tileset);
  return tileset;
}

TEST_CASE("chunks come nearest first, show the picture of one chunk, and the coarse surface where one is missing") {
  std::vector<SiteFile> files = sites_and_test("network_test.html", {});
  const std::vector<SiteFile> in_chunks = site_in_chunks();
  for (const SiteFile& file : in_chunks) {
    files.push_back(in_folder("chunks", file));
    files.push_back(in_folder("hole", file));
  }
  const json tileset = with_coarse_surface(files, "hole");
  const std::vector<std::string> expected = chunks_by_distance(tileset);
  REQUIRE(expected.size() >= kManyChunks);
  // The first chunk has the tables of tiles.
  const std::string first = chunks_below(tileset["root"])[0]["content"]["uri"];
  const std::string lost = "hole/" + expected[expected[0] == first ? 1 : 0];
  std::atomic<bool> is_mended = false;
  const Network network = [&](const std::string& name) -> Trouble {
    if (name == kMended) is_mended = true;
    return {name == lost && !is_mended ? Kind::refused : Kind::none, {}};
  };
  const Said said = said_in_browser(files, "/test.html#chunks", network);
  if (said.empty()) return;
  CHECK(problem_of(said) == "");
  REQUIRE(said.contains("hole-later-psnr"));
  // The page reads small parts of the first chunk beforehand, which list the resident tiles, and the whole of it later.
  std::istringstream names(said.at("chunks-order"));
  const std::vector<std::string> order(std::istream_iterator<std::string>(names), {});
  REQUIRE(order.size() == expected.size());
  for (std::size_t i = 0; i < order.size(); ++i) {  // two are on their way at a time
    const auto place = std::find(expected.begin(), expected.end(), order[i]) - expected.begin();
    CHECK(std::abs(place - static_cast<std::ptrdiff_t>(i)) <= 1);
  }
  CHECK(said.at("chunks-line") == "");
  CHECK(std::stod(said.at("chunks-psnr")) > 60);
  CHECK(said.at("hole-line") == "A part of the fine mesh is missing: " + lost.substr(5) +
                                    " cannot be loaded: the server says 503. What is there is shown, and the page "
                                    "tries again.");
  CHECK(std::stod(said.at("hole-psnr")) > 45);
  CHECK(said.at("hole-photographs") == "12");
  CHECK(said.at("hole-later") == " true");
  CHECK(std::stod(said.at("hole-later-psnr")) > 60);
}

TEST_CASE("a page shows the coarse surface from the first view before it knows the others") {
  std::vector<SiteFile> files = sites_and_test("network_test.html", {});
  std::string list;
  for (const SiteFile& file : site_in_chunks(kSiteViews - 1)) {
    files.push_back(in_folder("listed", file));
    if (file.name.starts_with("views-")) list = file.name;
  }
  const json tileset = with_coarse_surface(files, "listed");
  REQUIRE_FALSE(list.empty());
  CHECK(file_named(files, "listed/" + list).bytes.size() ==
        tileset["extensions"]["LUMATLAS_lumigraph"]["viewFile"]["byteLength"]);
  std::mutex mutex;
  bool is_mended = false;
  int before = 0;  // files of chunks and photographs that were asked for before the list was there
  const Network network = [&](const std::string& name) -> Trouble {
    const std::lock_guard lock(mutex);
    if (name == kMended) is_mended = true;
    if (!is_mended && (name.starts_with("listed/surface-") || name.starts_with("listed/images/"))) ++before;
    return {name == "listed/" + list && !is_mended ? Kind::refused : Kind::none, {}};
  };
  const Said said = said_in_browser(files, "/test.html#listed", network);
  if (said.empty()) return;
  CHECK(problem_of(said) == "");
  REQUIRE(said.contains("listed-psnr"));
  CHECK(said.at("listed-line") == "The list of photographs is missing: " + list +
                                      " cannot be loaded: the server says 503. What is there is shown, and the page "
                                      "tries again.");
  CHECK(std::stod(said.at("listed-colours")) > 30);  // all of the surface is the coarse one; black would be 7 dB
  CHECK(before == 0);
  CHECK(said.at("listed-later") == " 12 views, 12 photographs, told of a new version once");
  CHECK(std::stod(said.at("listed-psnr")) > 60);
}

TEST_CASE("chunks that do not fit give way to those that the camera needs") {
  std::vector<SiteFile> files = sites_and_test("network_test.html", {});
  for (const SiteFile& file : site_in_chunks()) files.push_back(in_folder("chunks", file));
  const Said said = said_in_browser(files, "/test.html#crowded");
  if (said.empty()) return;
  CHECK(problem_of(said) == "");
  CHECK(said.at("crowded") == " true true true true");
  CHECK(said.at("crowded-3") == "true true 0");
  CHECK(said.at("crowded-8") == "true true 0");
  CHECK(said.at("crowded-moved") == "true");
  CHECK(said.at("crowded-whole") == "true 0");
  CHECK(std::stod(said.at("crowded-psnr")) > 60);
}

TEST_CASE("a manifest says how many bytes the files have") {
  std::vector<SiteFile> files = site_files();
  const json tileset = parsed(file_named(files, "tileset.json"));
  const json& images = tileset["extensions"]["LUMATLAS_lumigraph"]["images"];
  CHECK(images.size() >= 3 * kSiteViews);
  for (const json& image : images) CHECK(file_named(files, image["uri"]).bytes.size() == image["byteLength"]);
  const json& content = tileset["root"]["content"];
  CHECK(file_named(files, content["uri"]).bytes.size() == content["extras"]["byteLength"]);
}

TEST_CASE("a page whose site was written anew shows the new site") {
  std::vector<SiteFile> files = sites_and_test("network_test.html", {"old"});
  // An intermediate cache answers with the old manifest, which names a file that is gone, until it is asked anew.
  SiteFile& manifest = file_named(files, "old/tileset.json");
  const SiteFile now = manifest;
  json scene = parsed(manifest);
  scene["root"]["content"]["uri"] = "surface-of-before.glb";
  store(manifest, scene);
  files.push_back(now);
  files.back().name = "old/now.json";
  for (const SiteFile& file : site_in_chunks()) files.push_back(in_folder("oldchunks", file));
  SiteFile& of_chunks = file_named(files, "oldchunks/tileset.json");
  const SiteFile chunks_now = of_chunks;
  json chunks = parsed(of_chunks);
  json* chunk = &chunks["root"];
  while (chunk->contains("children")) chunk = &(*chunk)["children"][1];
  (*chunk)["content"]["uri"] = "surface-of-before.glb";
  store(of_chunks, chunks);
  files.push_back(chunks_now);
  files.back().name = "oldchunks/now.json";
  const Said said = said_in_browser(files, "/test.html#old");
  if (said.empty()) return;
  CHECK(problem_of(said) == "");
  CHECK(said.at("old") == "4 of 4 pictures alike, missing: ");
  CHECK(said.at("old-chunks") == "true ");
}

TEST_CASE("requests are made a bounded number of times, with growing pauses, and end when the page is closed") {
  std::mutex mutex;
  std::vector<std::chrono::steady_clock::time_point> times;
  const Network network = [&](const std::string& name) -> Trouble {
    if (name != "tries/poster.jpg") return {};
    const std::lock_guard lock(mutex);
    times.push_back(std::chrono::steady_clock::now());
    return {Kind::refused, {}};
  };
  std::vector<SiteFile> files = sites_and_test("network_test.html", {"tries"});
  files.push_back(text_file("tries/poster.jpg", "image/jpeg", "never to be had"));
  const Said said = said_in_browser(files, "/test.html#tries", network);
  if (said.empty()) return;
  CHECK(problem_of(said) == "");
  REQUIRE(said.contains("aborted"));
  CHECK(said.at("refused") == "poster.jpg cannot be loaded: the server says 503");
  CHECK(said.at("aborted") == "AbortError");
  REQUIRE(times.size() == 5);  // four tries, and one before it is told to end
  std::chrono::milliseconds pause(100);
  for (std::size_t i = 1; i < 4; ++i, pause *= 2) CHECK(times[i] - times[i - 1] >= pause);
}

}  // namespace
}  // namespace lumatlas
