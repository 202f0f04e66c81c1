// SPDX-License-Identifier: GPL-3.0-or-later
// The answers to a page that asks again and again for a model that changes.
#include "tools/viewer/live_site.h"

#include <httplib.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "atlas/model/content_digest.h"
#include "blend/tables/fade_zone_shares.h"
#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/view_parts.h"

namespace lumatlas {
namespace {

using nlohmann::json;

// One view a version; files go with the version after the next.
constexpr LiveSiteTimes kOneView{std::chrono::seconds(-1), {}};

Snapshot room(std::size_t views) {
  return room_snapshot(views, {}, {16, 2, 0});
}

// The snapshot without the view in a slot.
Snapshot without(Snapshot snapshot, ViewSlot slot) {
  for (std::size_t tile = snapshot.tiles.first_tile[slot]; tile < snapshot.tiles.first_tile[slot + 1]; ++tile) {
    snapshot.tiles.places[tile] = TilePlace::none;
  }
  leave_out_views_without_tiles(snapshot);
  REQUIRE_FALSE(snapshot.views[slot]);
  return snapshot;
}

// A server while this lives, and what it answers.
class RunningLive {
 public:
  RunningLive() {
    thread_ = std::thread([this] { server.serve([this] { return stop_.load(); }); });
    const std::string address = server.address();
    port_ = std::stoi(address.substr(address.rfind(':') + 1));
  }
  ~RunningLive() {
    stop_ = true;
    thread_.join();
  }
  RunningLive(const RunningLive&) = delete;
  RunningLive& operator=(const RunningLive&) = delete;

  [[nodiscard]] int status(const std::string& path) const {
    return httplib::Client("127.0.0.1", port_).Get("/" + path)->status;
  }
  [[nodiscard]] std::string text(const std::string& path) const {
    return httplib::Client("127.0.0.1", port_).Get("/" + path)->body;
  }
  [[nodiscard]] json read(const std::string& path) const { return json::parse(text(path)); }

  SiteServer server{ServerOptions{}};

 private:
  std::atomic<bool> stop_ = false;
  std::thread thread_;
  int port_ = 0;
};

// A version of a model as its page reads it.
struct Read {
  json tileset, surface;

  explicit Read(const RunningLive& running)
      : tileset(running.read("tileset.json")), surface(running.read(tileset["root"]["content"]["uri"])) {}

  [[nodiscard]] const json& properties() const { return tileset["extensions"]["LUMATLAS_lumigraph"]; }
  [[nodiscard]] const json& views() const { return properties()["views"]; }
  // The name of the file that a view's photograph or mask is in.
  [[nodiscard]] std::string image(std::size_t view, const char* kind = "image") const {
    return properties()["images"][views()[view][kind].get<std::size_t>()]["uri"];
  }
  // The name of the file of the mesh, 0, the colours, 1, or the tables, 2.
  [[nodiscard]] std::string buffer(std::size_t number) const { return surface["buffers"][number]["uri"]; }
  [[nodiscard]] std::set<std::string> files() const {
    std::set<std::string> files{tileset["root"]["content"]["uri"], buffer(0), buffer(1), buffer(2)};
    for (const json& image : properties()["images"]) files.insert(image["uri"].get<std::string>());
    return files;
  }
};

TEST_CASE("a page waits until there is a photograph, and is told when nothing will follow") {
  RunningLive running;
  LiveSite site(running.server, "room");
  CHECK(running.status("index.html") == 200);
  CHECK(running.status("tileset.json") == 404);
  CHECK(running.read("live.json") == json{{"version", 0}, {"last", false}});
  Snapshot empty = room(1);
  empty.views.assign(1, nullptr);
  site.update(empty, false);
  CHECK(running.read("live.json")["version"] == 0);
  site.update(room(3), false);
  CHECK(running.read("live.json") == json{{"version", 1}, {"last", false}});
  site.update(room(3), true);
  CHECK(running.read("live.json") == json{{"version", 2}, {"last", true}});
}

TEST_CASE("a page opens at a photograph that was held level") {
  RunningLive running;
  LiveSite site(running.server, "room");
  Snapshot snapshot = room(12);
  site.update(snapshot, false);
  const std::size_t first = Read(running).properties()["firstView"];
  StoredView rolled = *snapshot.views[first];
  rolled.camera.cam_from_world_rotation =
      glm::dmat3(glm::rotate(glm::dmat4(1), glm::radians(20.0), glm::dvec3(0, 0, 1))) *
      rolled.camera.cam_from_world_rotation;
  snapshot.views[first] = std::make_shared<const StoredView>(std::move(rolled));
  site.update(snapshot, true);
  CHECK(Read(running).properties()["firstView"] != first);
}

TEST_CASE("what did not change keeps its name, and what no version needs any more goes") {
  RunningLive running;
  LiveSite site(running.server, "room", {.kept = {}});
  site.update(room(3), false);
  const Read first(running);
  Snapshot moved = room(5);  // made anew: only what follows differs
  auto other = std::make_shared<StoredView>(*moved.views[1]);
  change_colors(*other, [](std::uint8_t value) { return value ^ 0x40; });
  moved.views[1] = other;
  site.update(moved, false);
  const Read second(running);
  CHECK(second.buffer(0) == first.buffer(0));
  CHECK(second.image(0) == first.image(0));
  CHECK(second.image(0, "mask") == first.image(0, "mask"));
  CHECK(second.image(1) != first.image(1));
  CHECK(second.views().size() == 5);
  // A page may still be fetching the version before.
  for (const std::string& file : first.files()) CHECK(running.status(file) == 200);
  for (const std::string& file : second.files()) CHECK(running.status(file) == 200);
  CHECK(second.buffer(2) != first.buffer(2));
  site.update(moved, false);
  const Read third(running);
  CHECK(third.tileset == second.tileset);
  FallbackColors::Colors colors = moved.vertex_colors.get();
  colors.front().r ^= 1;
  moved.vertex_colors = std::move(colors);
  site.update(moved, false);
  const Read last(running);
  CHECK(last.buffer(0) == third.buffer(0));
  CHECK(last.buffer(1) != third.buffer(1));
  CHECK(last.buffer(2) == third.buffer(2));
  const std::set<std::string> kept = last.files(), before = third.files();
  for (const std::string& file : first.files()) {
    CHECK(running.status(file) == (kept.contains(file) || before.contains(file) ? 200 : 404));
  }
}

TEST_CASE("files of a version stay for a while after it is replaced, as a slow page needs") {
  RunningLive running;
  LiveSite site(running.server, "room");
  std::set<std::string> all;
  for (std::size_t views = 1; views <= 5; ++views) {
    site.update(room(views), false);
    all.merge(Read(running).files());
  }
  CHECK(all.size() > Read(running).files().size());
  for (const std::string& file : all) CHECK(running.status(file) == 200);
}

TEST_CASE("new photographs come first, and other views that change have their turns") {
  RunningLive running;
  LiveSite site(running.server, "room", kOneView);
  Snapshot snapshot = room(4);
  for (int version = 0; version < 3; ++version) site.update(without(snapshot, ViewSlot{3}), false);
  const auto change_masks = [&](std::uint8_t value) {
    for (ViewSlot slot{0}; slot < 3; ++slot) {
      auto changed = std::make_shared<StoredView>(*snapshot.views[slot]);
      ViewMask& mask = own_mask(*changed);
      mask.validity = std::vector<std::uint8_t>(mask.validity.size(), value);
      snapshot.views[slot] = std::move(changed);
    }
  };
  const Read before(running);
  change_masks(100);
  CHECK_FALSE(site.update(snapshot, false));
  CHECK(Read(running).views()[3].is_object());
  CHECK(Read(running).image(0, "mask") == before.image(0, "mask"));
  // All masks change with each version, and none is left behind.
  for (const int value : {110, 120, 130}) {
    change_masks(static_cast<std::uint8_t>(value));
    CHECK_FALSE(site.update(snapshot, false));
  }
  for (std::size_t view = 0; view < 3; ++view) {
    CHECK(Read(running).image(view, "mask") != before.image(view, "mask"));
    CHECK(Read(running).image(view) == before.image(view));
  }
}

TEST_CASE("a page is never told a view with the photograph of the view that it replaced") {
  RunningLive running;
  LiveSite site(running.server, "room", kOneView);
  Snapshot snapshot = room(3);
  for (int version = 0; version < 3; ++version) site.update(snapshot, false);
  const Read before(running);
  const auto replace = [&](ViewSlot slot) {
    auto other = std::make_shared<StoredView>(*snapshot.views[slot]);
    change_colors(*other, [](std::uint8_t value) { return value ^ 0x40; });
    snapshot.views[slot] = std::move(other);
  };
  replace(ViewSlot{0});
  replace(ViewSlot{1});
  CHECK_FALSE(site.update(without(snapshot, ViewSlot{2}), false));
  const Read now(running);
  CHECK(now.image(0) != before.image(0));
  CHECK(now.views()[1].is_null());
  CHECK(now.views()[2].is_null());
  // A slot that was free meanwhile has the new view's photograph or none.
  replace(ViewSlot{2});
  CHECK_FALSE(site.update(snapshot, false));
  CHECK(site.update(snapshot, false));
  const Read last(running);
  for (std::size_t view = 0; view < 3; ++view) CHECK(last.image(view) != before.image(view));
}

TEST_CASE("a photograph that comes back after another took its place is written again") {
  RunningLive running;
  LiveSite site(running.server, "room", kOneView);
  const Snapshot first = room(3);
  for (int version = 0; version < 3; ++version) site.update(first, false);
  const std::string photograph = Read(running).image(2);
  Snapshot other = first;
  for (ViewSlot slot{0}; slot < 3; ++slot) {
    auto view = std::make_shared<StoredView>(*first.views[slot]);
    change_colors(*view, [](std::uint8_t value) { return value ^ 0x40; });
    other.views[slot] = std::move(view);
  }
  for (int version = 0; version < 2; ++version) CHECK_FALSE(site.update(other, false));  // no time for the last
  CHECK(running.status(photograph) == 404);
  other.views[2] = first.views[2];
  CHECK(site.update(other, false));
  CHECK(Read(running).image(2) == photograph);
  for (const std::string& file : Read(running).files()) CHECK(running.status(file) == 200);
}

TEST_CASE("of views that there was no time for, a page is told no tiles") {
  const Snapshot all = room(3);
  Snapshot some = all;
  const std::size_t first = some.tiles.first_tile[1], last = some.tiles.first_tile[2], end = some.tiles.places.size();
  for (std::size_t tile = first; tile < end; ++tile) some.tiles.places[tile] = TilePlace::none;
  leave_out_views_without_tiles(some);
  REQUIRE_FALSE(some.views[1]);
  REQUIRE_FALSE(some.views[2]);
  LiveForm form({}, [](const Surface& surface) { return share_cells(surface, surface.cells.size); });
  json surface;
  const PutFormFile put = [&](const FormFile& file) {
    if (file.ending == ".gltf") surface = json::parse(file.bytes.begin(), file.bytes.end());
    return name_by_content(file.stem, file.ending, file.bytes);
  };
  const auto tiles = [&] {
    const auto accessor = surface["extensions"]["LUMATLAS_lumigraph"]["resident"].get<std::size_t>();
    return surface["accessors"][accessor]["count"].get<std::size_t>();
  };
  const auto views = [](const FormVersion& version) {
    return json::parse(version.tileset)["extensions"]["LUMATLAS_lumigraph"]["views"];
  };
  const std::chrono::seconds enough = std::chrono::hours(1);
  (void)form.write(some, enough, put);
  CHECK(tiles() == first);
  const FormVersion more = form.write(all, std::chrono::seconds(-1), put);  // at least one more
  CHECK(views(more)[1].is_object());
  CHECK(views(more)[2].is_null());
  CHECK(tiles() == last);
  CHECK_FALSE(more.complete);
  CHECK(views(form.write(all, enough, put))[2].is_object());
  CHECK(tiles() == all.tiles.places.size());
}

TEST_CASE("shaders are in a file of their own, which no version changes") {
  RunningLive running;
  LiveSite site(running.server, "room");
  const std::string before = running.text("shaders.json");
  const json shaders = json::parse(before);
  CHECK_THAT(shaders["sources"]["blend.frag"], Catch::StartsWith("#version 300 es"));
  for (const std::size_t views : {3, 5}) {
    site.update(room(views), false);
    CHECK(running.text("shaders.json") == before);
    // The part that is fetched again with each version: a few hundred bytes a view.
    const std::string scene = running.text("tileset.json");
    CHECK(scene.find("#version") == std::string::npos);
    CHECK(scene.size() < 2000 + 1200 * views);
  }
}

TEST_CASE("a version that fails or is stopped leaves the one before") {
  RunningLive running;
  LiveSite site(running.server, "room");
  site.update(room(3), false);
  const json before = running.read("tileset.json");
  Snapshot bad = room(4);
  bad.gains.pop_back();
  CHECK_THROWS_AS(site.update(bad, false), std::invalid_argument);
  int ticks = 0;
  CHECK_THROWS_AS(site.update(room(5), false,
                              [&] {
                                if (++ticks == 3) throw std::runtime_error("stop");
                              }),
                  std::runtime_error);
  CHECK(running.read("live.json")["version"] == 1);
  CHECK(running.read("tileset.json") == before);
  site.update(room(5), false);
  CHECK(Read(running).views().size() == 5);
}

TEST_CASE("files of a version that is stopped do not stay") {
  std::set<std::string> coming;  // files of the version that is stopped, without those of the one before
  {
    RunningLive other;
    LiveSite site(other.server, "room");
    site.update(room(3), false);
    const std::set<std::string> before = Read(other).files();
    site.update(room(5), false);
    for (const std::string& name : Read(other).files()) {
      if (!before.contains(name)) coming.insert(name);
    }
  }
  RunningLive running;
  LiveSite site(running.server, "room");
  site.update(room(3), false);
  const std::set<std::string> before = Read(running).files();
  const auto is_there = [&](const std::string& name) { return running.status(name) == 200; };
  CHECK_THROWS_AS(site.update(room(5), false,
                              [&] {
                                if (std::any_of(coming.begin(), coming.end(), is_there)) {
                                  throw std::runtime_error("stop");
                                }
                              }),
                  std::runtime_error);
  CHECK(std::none_of(coming.begin(), coming.end(), is_there));
  CHECK(std::all_of(before.begin(), before.end(), is_there));
  site.update(room(5), false);
  CHECK(std::all_of(coming.begin(), coming.end(), is_there));
}

TEST_CASE("a snapshot looks like another until something that is drawn differs") {
  const Snapshot scene = room(3);
  CHECK(look_alike(scene, scene));
  Snapshot other = scene;
  other.cell_coverage.assign(scene.cell_seen.size(), 1.0F);
  CHECK(look_alike(scene, other));
  other.gains[1].g *= 1.5;
  CHECK_FALSE(look_alike(scene, other));
  other = scene;
  other.views[1] = std::make_shared<StoredView>(*scene.views[1]);
  CHECK_FALSE(look_alike(scene, other));
  other = scene;
  ViewSlot& first = other.references.views.front();
  first = ViewSlot(first ^ 1u);
  CHECK_FALSE(look_alike(scene, other));
  other = scene;
  FallbackColors::Colors colors = other.vertex_colors.get();
  colors.front().r ^= 1;
  other.vertex_colors = std::move(colors);
  CHECK_FALSE(look_alike(scene, other));
}

std::size_t shown_views(const RunningLive& running) {
  const json views = Read(running).views();
  return std::count_if(views.begin(), views.end(), [](const json& view) { return view.is_object(); });
}

TEST_CASE("a model of which a page lacks some photographs is kept until it has them, whatever comes after it") {
  RunningLive running;
  LiveSite site(running.server, "room", kOneView);
  auto model = std::make_shared<const Snapshot>(room(3));
  const std::weak_ptr<const Snapshot> kept = model;
  Snapshot empty = room(1);
  empty.views.assign(1, nullptr);
  std::atomic<int> asked = 0;
  const auto showing = show_while_it_changes(
      site,
      [&]() -> std::shared_ptr<const Snapshot> {
        ++asked;
        if (asked == 1) return std::exchange(model, nullptr);
        return asked == 2 ? std::make_shared<const Snapshot>(empty) : nullptr;
      },
      ShowingShare::little, [&](const std::string& why) { FAIL_CHECK(why); });
  std::size_t most_shown = 0;
  for (int i = 0; i < 1500 && most_shown < 3; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (running.read("live.json")["version"] == 0) continue;
    const bool is_kept = !kept.expired();
    const std::size_t shown = shown_views(running);  // at least as many as when it was looked whether it is kept
    if (shown < 3) CHECK(is_kept);
    most_shown = std::max(most_shown, shown);
  }
  CHECK(most_shown == 3);
  CHECK(asked >= 2);
  for (int i = 0; i < 500 && !kept.expired(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  CHECK(kept.expired());
}

TEST_CASE("what changes is shown by a thread, and what it cannot show is said") {
  RunningLive running;
  LiveSite site(running.server, "room");
  const Snapshot good = room(3);
  std::atomic<int> asked = 0, told = 0;
  {
    const auto showing = show_while_it_changes(
        site,
        [&]() -> std::shared_ptr<const Snapshot> {
          if (++asked == 1) throw std::runtime_error("a bad model");
          return asked == 2 ? std::make_shared<const Snapshot>(good) : nullptr;
        },
        ShowingShare::much,
        [&](const std::string& why) {
          CHECK(why == "a bad model");
          ++told;
        });
    for (int i = 0; i < 500 && running.read("live.json")["version"] == 0; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    CHECK(running.read("live.json")["version"] == 1);
  }
  CHECK(told == 1);
  const int then = asked;
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  CHECK(asked == then);
}

}  // namespace
}  // namespace lumatlas
