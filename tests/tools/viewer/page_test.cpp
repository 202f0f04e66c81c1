// SPDX-License-Identifier: GPL-3.0-or-later
// The page of a small model, in a browser: it draws what the renderer draws, and does what its visitors ask for.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/model/content_digest.h"
#include "atlas/model/live_form.h"
#include "blend/renderer.h"
#include "blend/tables/fade_zone_shares.h"
#include "blend/tables/ranked_references.h"
#include "mesh/visibility/visibility.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/view_parts.h"
#include "tests/support/scenes/wall_scenes.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/viewer/browser.h"
#include "tests/tools/viewer/test_site.h"
#include "tools/frame/background.h"
#include "tools/picture/photographed_share.h"
#include "tools/viewer/site.h"

namespace lumatlas {
namespace {

constexpr std::size_t kFollowed = 4;  // of the stored ones, of a model that changed
constexpr double kCornerAt = 3.3;     // x from which the surface is elsewhere, in a version of it
constexpr std::size_t kFew = 4;       // of the stored ones, of compressed texels
constexpr std::size_t kWide = 4;      // of the stored ones, from outside of the room

// The model with the corner of its surface from `least` on, along x, at another place.
Snapshot with_moved_corner(Snapshot snapshot, double least) {
  Surface surface = *snapshot.surface;
  for (glm::vec3& position : surface.mesh.positions) {
    if (position.x > least) position.x += 2;
  }
  for (Cell& cell : surface.cells.cells) {
    if (cell.centroid.x + cell.radius > least) cell.radius += 2;  // some of its faces may be stretched
    if (cell.centroid.x > least) cell.centroid.x += 2;
  }
  snapshot.surface = std::make_shared<const Surface>(std::move(surface));
  return snapshot;
}

// Two versions of a model that changes in a folder, the scene of the second beside the first.
void add_versions(std::vector<SiteFile>& files, const std::string& folder, const LiveFormOptions& options,
                  double moved_from) {
  LiveForm form(
      options, [&](const Surface& surface) { return share_cells(surface, options.border_width * surface.cells.size); });
  std::mutex mutex;
  std::map<std::string, SiteFile> parts;
  const PutFormFile put = [&](const FormFile& file) {
    const std::string name = name_by_content(file.stem, file.ending, file.bytes);
    const std::lock_guard lock(mutex);
    parts.emplace(name, SiteFile{name, file.type, {file.bytes.begin(), file.bytes.end()}});
    return name;
  };
  for (const SiteFile& file : page_files("live")) files.push_back(in_folder(folder, file));
  Snapshot first = with_moved_corner(site_model(), moved_from);  // whose last views have not come yet
  const std::uint32_t first_missing = first.tiles.first_tile[kSiteViews - 4];
  for (std::size_t tile = first_missing; tile < first.tiles.places.size(); ++tile)
    first.tiles.places[tile] = TilePlace::none;
  leave_out_views_without_tiles(first);
  auto masked = std::make_shared<StoredView>(*first.views[0]);  // of which the second version has all
  std::vector<std::uint8_t> validity = masked->mask->validity.all();
  std::fill(validity.begin() + static_cast<std::ptrdiff_t>(validity.size() / 3), validity.end(), 0);
  own_mask(*masked).validity = std::move(validity);
  first.views[0] = std::move(masked);
  auto moved = std::make_shared<StoredView>(*first.views[1]);
  moved->camera.cam_from_world_translation.x += 0.3;
  first.views[1] = std::move(moved);
  const std::chrono::seconds enough = std::chrono::hours(1);
  const std::string type = "application/json";
  files.push_back(text_file(folder + "/tileset.json", type, form.write(first, enough, put).tileset));
  files.push_back(text_file(folder + "/second.json", type, form.write(site_model(), enough, put).tileset));
  for (const auto& [name, file] : parts) files.push_back(in_folder(folder, file));
}

std::vector<SiteFile> site_and_test() {
  std::vector<SiteFile> files = site_files();
  constexpr double kNowhere = 1e9;
  add_versions(files, "live", {.photographs = {ImageFormat::png}, .border_width = 1}, kNowhere);
  LiveFormOptions chunked{.photographs = {ImageFormat::png}, .border_width = 1, .least_chunked = 0, .chunk_cells = 2};
  add_versions(files, "live-chunked", chunked, kCornerAt);
  files.push_back(cameras_file());
  for (SiteFile& file : test_page_files("page_test.html")) files.push_back(std::move(file));
  return files;
}

struct Agreement {
  double psnr = 0;   // over pixels that both say are surface, dB
  double other = 0;  // share of pixels that only one of the two says are surface
};

// Compares the first `count` expected pictures with those that the page said by that name.
Agreement agreement(const std::vector<Rendering>& expected, const Said& said, const std::string& name,
                    std::size_t count) {
  double squares = 0;
  std::size_t compared = 0, other = 0, all = 0;
  for (std::size_t number = 0; number < count; ++number) {
    REQUIRE(said.contains(name + std::to_string(number)));
    const std::string& pixels = said.at(name + std::to_string(number));
    const Rendering& rendering = expected[number];
    REQUIRE(pixels.size() == 4 * rendering.state.size());
    for (std::size_t i = 0; i < rendering.state.size(); ++i, ++all) {
      const bool surface = rendering.state[i] != PixelState::empty;
      if (surface != (pixels[4 * i + 3] != 0)) ++other;
      if (!surface) continue;
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const double difference =
            static_cast<std::uint8_t>(pixels[4 * i + channel]) - rendering.picture.rgb[3 * i + channel];
        squares += difference * difference;
      }
      ++compared;
    }
  }
  const double mean = squares / (3.0 * static_cast<double>(compared));
  return {10 * std::log10(255.0 * 255.0 / mean), static_cast<double>(other) / static_cast<double>(all)};
}

// Compares what the page shows where pictures have no surface with what `lumatlas render` shows there, by cameras
// from outside of the room.
double surroundings_psnr(const Said& said) {
  Renderer renderer;
  renderer.load(site_model());
  double squares = 0;
  std::size_t compared = 0;
  for (std::size_t number = 0; number < kWide; ++number) {
    Camera camera = site_cameras()[number];
    camera.cam_from_world_translation.z += 8;
    const Rendering rendering = renderer.render(camera, {});
    const SoftPicture soft = with_background(rendering, {});
    const std::string& pixels = said.at("whole-" + std::to_string(number));
    REQUIRE(pixels.size() == 4 * rendering.state.size());
    for (std::size_t i = 0; i < rendering.state.size(); ++i) {
      if (rendering.state[i] != PixelState::empty) continue;
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const double difference =
            static_cast<std::uint8_t>(pixels[4 * i + channel]) - soft.picture.rgb[3 * i + channel];
        squares += difference * difference;
      }
      ++compared;
    }
  }
  std::cout << "the page's surroundings: " << compared << " pixels, ";
  CHECK(compared > 1000);
  return 10 * std::log10(255.0 * 255.0 * 3.0 * static_cast<double>(compared) / squares);
}

// How near compressed texels are to what they were made of.
struct TexelNearness {
  double psnr = 0;                       // of colours, dB
  double validity_rms = 0;               // of 255
  std::size_t validities_changed = 999;  // of 0 to something, or the other way
};

TexelNearness texel_nearness(const std::string& said) {
  TexelNearness result;
  std::istringstream(said) >> result.psnr >> result.validity_rms >> result.validities_changed;
  return result;
}

std::vector<Rendering> rendered(const Snapshot& snapshot) {
  Renderer renderer;
  renderer.load(snapshot);
  std::vector<Rendering> renderings;
  for (const Camera& camera : site_cameras()) renderings.push_back(renderer.render(camera, {}));
  return renderings;
}

// Compares the page's bounds of weights with bound_of_weight(). Returns how many there are.
std::size_t check_bounds(const std::string& said) {
  std::istringstream lines(said);
  std::size_t count = 0;
  Ball ball;
  glm::dvec3 novel, stored;
  double bound = 0;
  while (lines >> ball.center.x >> ball.center.y >> ball.center.z >> ball.radius >> novel.x >> novel.y >> novel.z >>
         stored.x >> stored.y >> stored.z >> bound) {
    CHECK(bound == Approx(bound_of_weight(ball, novel, stored, {})).margin(1e-9));
    ++count;
  }
  return count;
}

// Compares the shares of the stored views' own pictures that the page finds photographed with photographed_share().
// Returns their number.
std::size_t check_own_shares(const std::string& said) {
  const Snapshot model = site_model();
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(model.surface->mesh);
  std::istringstream numbers(said);
  std::size_t count = 0;
  std::uint32_t slot = 0;
  for (double share = 0; numbers >> slot >> share; ++count) {
    CAPTURE(slot);
    CHECK(share == Approx(photographed_share(model, *visibility, model.views.at(slot)->camera)).margin(0.02));
  }
  return count;
}

TEST_CASE("a browser draws what the renderer draws, and follows its visitor") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const std::vector<Rendering> expected = rendered(site_model());
  const Said said = said_in_browser(site_and_test(), "/test.html");
  if (said.empty()) return;
  INFO(problem_of(said));
  CHECK(problem_of(said).empty());
  REQUIRE(said.contains("bytes"));

  const Agreement agreed = agreement(expected, said, "picture-", expected.size());
  std::cout << "the page's pictures: PSNR " << agreed.psnr << " dB against the renderer's, " << 100 * agreed.other
            << " % of pixels have surface in one of them only\n";
  CHECK(agreed.psnr > 40);
  CHECK(agreed.other < 0.002);  // rasterisers may disagree about a pixel whose middle is on an edge
  const double surroundings = surroundings_psnr(said);
  std::cout << "PSNR " << surroundings << " dB\n";
  CHECK(surroundings > 45);
  CHECK(std::stod(said.at("bytes")) < 50e6);
  CHECK(said.at("unranked") == "0 true");
  CHECK(check_bounds(said.at("bounds")) > 100);
  // Both forms are coarser than the renderer's, most where masks rise: on these photographs of 96 x 72 pixels that is
  // much of them. Whether a texel is valid stays.
  constexpr double kLeastPsnr = 35;
  std::cout << "compressed texels";
  CHECK(said.at("validities") == "all none part");
  for (const std::string form : {"bc7", "etc2"}) {
    const double by_page = agreement(expected, said, form + "-", kFew).psnr;
    const TexelNearness texels = texel_nearness(said.at(form + "-texels"));
    std::cout << ", PSNR " << by_page << " dB by " << form << ", whose texels have " << texels.psnr
              << " dB, validities " << texels.validity_rms;
    CHECK(by_page > kLeastPsnr);
    CHECK(texels.psnr > 37);
    CHECK(texels.validity_rms < 4);
    CHECK(texels.validities_changed == 0);
    CHECK(said.at(form + "-photographs") == "12 " + form);
  }
  std::cout << '\n';
  CHECK(said.at("etc2-bytes") == said.at("bc7-bytes"));
  CHECK(std::stod(said.at("etc2-bytes")) < std::stod(said.at("photograph-bytes")));
  CHECK(said.at("forms") == "bc7 etc2 rgb8");
  // The second pair is of a slow GPU, which draws the surface of a still frame once, where interactive frames are
  // drawn.
  CHECK(said.at("still-sizes") == "96x72 192x144, 96x72 96x72");
  // A page that had an earlier version draws the later one, and did not fetch what had not changed.
  CHECK(agreement(expected, said, "followed-", kFollowed).psnr > kLeastPsnr);
  CHECK(agreement(expected, said, "followed-", kFollowed).other < 0.002);
  CHECK(agreement(expected, said, "followed-chunked-", kFollowed).psnr > kLeastPsnr);
  CHECK(agreement(expected, said, "followed-chunked-", kFollowed).other < 0.002);
  // Some chunks stay, some are drawn with other tables alone, some are new, and some are gone.
  const auto chunks = nlohmann::json::parse(said.at("chunks-followed"));
  const auto count = [&](const char* name) { return chunks.at(name).get<int>(); };
  CHECK(count("same") > 0);
  CHECK(count("otherTables") > 0);
  CHECK(count("now") < count("before"));
  CHECK(count("meshes") == count("now") - count("same") - count("otherTables"));
  CHECK(count("tables") == count("now") - count("same"));
  CHECK(count("surfaces") == count("tables"));
  // All descriptions come in one answer, and then all meshes, colours and tables.
  CHECK(count("together") == 2);
  // One's mask is another, and one was moved, for whose new depths its mask is read again.
  CHECK(said.at("fetched-again") ==
        "images/00000-mask.png images/00000.png images/00001-mask.png images/00008-mask.png images/00008.png "
        "images/00009-mask.png images/00009.png images/00010-mask.png "
        "images/00010.png images/00011-mask.png images/00011.png surface.gltf tables.bin");
  CHECK(check_own_shares(said.at("own-shares")) == kSiteViews);
  CHECK(said.at("filled") == "1.000000 1.000000 1.000000");
  // With room for eight of twelve photographs, what is thrown away is what pictures do not need.
  const double tight = agreement(expected, said, "tight-", kStoredPoses).psnr;
  std::cout << "room for eight photographs: PSNR " << tight << " dB, " << said.at("tight-fetched") << " fetched\n";
  CHECK(tight > 40);
  CHECK(said.at("tight-memory") == "true 8/8");
  CHECK(std::stoi(said.at("tight-fetched")) > 8);
  CHECK(said.at("tight-again") == "0");

  // A model that does not fit at all says so in one sentence.
  REQUIRE(said.contains("notice-helped"));
  CHECK_THAT(
      said.at("notice"),
      Catch::Matches("complete true This model takes up to [1-9][0-9]* MiB of the GPU's memory, [0-9]+ of them for its "
                     "mesh, and this page is to take at most 0.5: build the model with fewer faces \\(lumatlas "
                     "build --faces\\), or add \\?memory=[1-9][0-9]* to this page's address\\."));
  CHECK(said.at("notice-true") == "true");
  CHECK(said.at("misplaced").empty());
  CHECK(said.at("notice-closed") == "true");
  CHECK(said.at("notice-helped") == "false true");

  REQUIRE(said.contains("screenshot"));
  CHECK(said.at("state") == "complete");
  CHECK(said.at("photographs") == "12/12");
  CHECK(said.at("thumbnails") == "12");
  CHECK(std::stod(said.at("jumped")) < 1e-3);
  CHECK(said.at("dragged") == "true");
  CHECK(said.at("let-go") == "true");
  CHECK(std::stod(said.at("stops")) == 0);
  CHECK(said.at("came-back") == "true");
  CHECK(said.at("screenshot") == "image/png true");
}

// A panel before a wall, both off, and a photograph from either side.
Snapshot panel_model() {
  const std::shared_ptr<const Surface> surface = wall_and_panel();
  Atlas atlas(surface, 2);
  for (const double aside : {-0.3, 0.4}) {
    const Camera camera = forward_camera(96, 72, {aside, 0.1, 0});
    atlas.insert(traced_view(*surface, aside < 0 ? "left" : "right", camera, position_photograph(96, 72)));
  }
  for (CellId cell{0}; cell < surface->cells.cells.size(); ++cell) atlas.set_references(cell, {0, 1});
  Snapshot snapshot = atlas.snapshot();
  snapshot.cell_deviation.assign(snapshot.cell_seen.size(), 0.05f);
  return snapshot;
}

TEST_CASE("a browser blurs depth edges as the renderer does, across the parts of a picture too") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot model = panel_model();
  std::vector<Camera> cameras;
  for (int i = 0; i < 6; ++i) cameras.push_back(forward_camera(700, 350, {0.17 * i - 0.4, 0.03 * i, 0.05 * i}));
  Renderer renderer;
  renderer.load(model);
  std::vector<Rendering> soft, sharp;
  BlendOptions options;
  options.soft_edges = false;
  for (const Camera& camera : cameras) {
    soft.push_back(renderer.render(camera, {}));
    sharp.push_back(renderer.render(camera, options));
  }
  std::vector<SiteFile> files = site_files(model);
  files.push_back(cameras_file(cameras));
  for (SiteFile& file : test_page_files("soft_edges_test.html")) files.push_back(std::move(file));
  const Said said = said_in_browser(files, "/test.html");
  if (said.empty()) return;
  CHECK(problem_of(said) == "");
  const Agreement with_soft = agreement(soft, said, "picture-", soft.size());
  const Agreement with_sharp = agreement(sharp, said, "picture-", sharp.size());
  std::cout << "the page's soft edges: PSNR " << with_soft.psnr << " dB against the renderer's, " << with_sharp.psnr
            << " against sharp ones\n";
  CHECK(with_soft.psnr > 45);
  CHECK(with_sharp.psnr < with_soft.psnr - 6);
}

// The script at the end of a page that says when all is there, by an address, for a page from a file may not post.
const std::string kTellsTheEnd = R"(<script>
const tell = setInterval(() => {
  const state = document.documentElement.dataset.state;
  if (!state) return;
  clearInterval(tell);
  location = 'SERVER/said/done?' + state + document.documentElement.dataset.photographs;
}, 100);
</script>)";

TEST_CASE("one file is the whole site, opened from a disk") {
  std::ostringstream page;
  const SiteFacts facts = write_one_page(page, site_model(), {});
  CHECK(facts.views == kSiteViews);
  CHECK(page.str().size() >= facts.bytes());
  CHECK(page.str().find("http://") == std::string::npos);
  CHECK(page.str().find("https://") == std::string::npos);
  const TemporaryFolder folder;
  // The server's address is known only once it listens: it is after the '#'.
  std::string tells = kTellsTheEnd;
  tells.replace(tells.find("'SERVER"), 7, "decodeURIComponent(document.URL.split('server=')[1]) + '");
  const auto file = folder.with_file("model.html", page.str() + tells);
  const Said said = said_in_browser({}, "file://" + file.string() + "#server={{server}}");
  if (said.empty()) return;
  REQUIRE(said.contains("done"));
  CHECK_THAT(said.at("done"), Catch::Contains("?complete12/12"));
}

TEST_CASE("photographs that are too large for a texture are scaled, and a browser takes what comes of it") {
  std::vector<SiteFile> files;
  SiteOptions options;
  options.most_side_px = 61;  // of 96
  const SiteFacts facts = write_site(site_model(), options, [&](SiteFile file) { files.push_back(std::move(file)); });
  CHECK(facts.scale == Approx(61.0 / 96));
  SiteFile& page = files.back();
  REQUIRE(page.name == "index.html");
  std::string tells = kTellsTheEnd;
  tells.replace(tells.find("'SERVER"), 7, "'");
  // The page's own policy allows no script within it.
  page.name = "other.html";
  std::string html(page.bytes.begin(), page.bytes.end());
  html.replace(html.find("script-src"), 10, "script-src 'unsafe-inline'");
  html += tells;
  page.bytes.assign(html.begin(), html.end());
  const Said said = said_in_browser(files, "/other.html");
  if (said.empty()) return;
  REQUIRE(said.contains("done"));
  CHECK_THAT(said.at("done"), Catch::Contains("?complete12/12"));
}

}  // namespace
}  // namespace lumatlas
