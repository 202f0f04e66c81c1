// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/build_model.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iostream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <sstream>
#include <stdexcept>

#include "atlas/model/model_file.h"
#include "mesh/base/errors.h"
#include "planner/coverage/predicted_loss.h"
#include "planner/refinement/photometry.h"
#include "tests/support/temporary_folder.h"
#include "tools/lab/synth/synth.h"
#include "tools/pipeline/build_settings.h"
#include "tools/pipeline/output/build_summary.h"
#include "tools/pipeline/output/model_inspection.h"
#include "tools/pipeline/output/save_model.h"
#include "tools/scene/forms/colmap/colmap_writer.h"
#include "tools/scene/growing_scene.h"

namespace lumatlas {
namespace {

using Names = std::vector<std::string>;

constexpr std::uint32_t kViews = 24;
constexpr std::uint64_t kBytesPerView = 64 * 48 * 10;  // colour 3, depth 4, trust, validity and rim 1 each

// An apartment of 24 views of 64 x 48.
const std::filesystem::path& small_scene() {
  static const TemporaryFolder folder;
  static const bool made = [] {
    SynthOptions options;
    options.views = kViews;
    options.width = 64;
    options.height = 48;
    options.samples = 1;
    options.triangles = 3000;
    write_synthetic_scene(options, folder.path());
    return true;
  }();
  REQUIRE(made);
  return folder.path();
}

BuildOptions options_for(std::uint32_t max_views, ViewChoice choice = ViewChoice::online) {
  BuildOptions options;
  options.max_views = max_views;
  options.choice = choice;
  options.refine = RefineMode::none;
  options.planner.min_view_gain = 0;
  options.cells.size = 0.6;  // a tenth of the cells that it would choose, which take most of the time
  options.tiles = kWholeViews;
  options.texture_px.reset();
  return options;
}

Names offered(const BuildResult& result) {
  Names names;
  for (const PlannedView& view : result.planned) names.push_back(view.name);
  return names;
}

Names stored(const Snapshot& snapshot) {
  Names names;
  for (const auto& view : snapshot.views) {
    if (view) names.push_back(view->name);
  }
  std::sort(names.begin(), names.end());
  return names;
}
Names stored(const BuildResult& result) {
  return stored(result.snapshot);
}

// The second half of a file is lost; its header is not.
void cut_off(const std::filesystem::path& file) {
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
}

TEST_CASE("options that break a rule are refused before anything is read") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto complaint = [](const BuildOptions& options) -> std::string {
    try {
      (void)build_model("/nowhere", options);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return {};
  };
  BuildOptions options;
  CHECK_THROWS_AS(build_model("/nowhere", options), InputError);  // good options: only the scene is missing
  options.planner.coverage.ideal_distance = kNan;
  CHECK(complaint(options) == "coverage: ideal_distance is nan, must be finite and above 0");
  options = {};
  options.planner.min_view_gain = kNan;
  CHECK(complaint(options) == "planner: min_view_gain is nan, must be finite and not negative");
  options = {};
  options.cells.size = std::numeric_limits<double>::infinity();
  CHECK(complaint(options) == "cells: size is inf, must be finite and not negative");
  options = {};
  options.faces.pixels = kNan;
  CHECK(complaint(options) == "faces: pixels is nan, must be finite and not negative");
  options = {};
  options.faces.faces = 0;
  CHECK(complaint(options) == "faces: faces is 0, must be at least 1");
  options = {};
  options.max_views = 0;
  CHECK(complaint(options) == "build: max_views is 0, must be at least 1");
  options = {};
  options.hold_out = HoldOut{1, 1};
  CHECK(complaint(options) == "hold is 1, must be at least 2");
}

TEST_CASE("snapshots that are taken while a model is built do not change it") {
  BuildOptions options;
  options.max_views = 8;
  options.refine = RefineMode::exposure;
  options.tiles = {16, 2, 0};
  options.bound = Bound::of_array(40 * place_bytes(options.tiles));  // so few that the planner must choose
  const BuildResult alone = build_model(small_scene(), options);
  const Atlas* watched = nullptr;
  std::size_t snapshots = 0;
  const BuildCallback look = [&](const BuildProgress&) {
    if (watched && !watched->snapshot().views.empty()) ++snapshots;
    return true;
  };
  const BuildResult result = build_model(small_scene(), options, look, [&](const Atlas& atlas) {
    watched = &atlas;
    return std::shared_ptr<void>(&snapshots, [&](void*) { watched = nullptr; });
  });
  CHECK(snapshots >= kViews);
  CHECK(watched == nullptr);
  const auto resident = [](const Snapshot& snapshot) {
    std::vector<bool> tiles;
    for (const TilePlace slot : snapshot.tiles.places) tiles.push_back(slot != TilePlace::none);
    return tiles;
  };
  CHECK(stored(result) == stored(alone));
  CHECK(resident(result.snapshot) == resident(alone.snapshot));
  const std::vector<bool> tiles = resident(alone.snapshot);
  CHECK(std::count(tiles.begin(), tiles.end(), true) <= 40);
  CHECK(result.snapshot.references.views == alone.snapshot.references.views);
  CHECK(result.snapshot.vertex_colors == alone.snapshot.vertex_colors);
}

// A folder beside the small scene that fills up: its mesh is there, and the poses of some photographs, JPEG.
class FillingScene {
 public:
  explicit FillingScene(std::size_t listed = kViews) {
    std::filesystem::copy(small_scene() / "mesh.ply", folder_ / "mesh.ply");
    std::filesystem::create_directory(images_);
    for (const SceneView& view : read_scene_views(small_scene(), glm::dvec3(0)).views) {
      views_.push_back({std::filesystem::path(view.name).replace_extension(".jpg").string(), view.camera});
      const auto bytes = encode_image(load_photograph(view), {ImageFormat::jpeg, 90});
      photographs_.emplace_back(bytes.begin(), bytes.end());
    }
    list(listed);
  }
  // Writes the poses of the first `count`.
  void list(std::size_t count) const {
    std::filesystem::create_directory(path() / "sparse");
    write_colmap_model(path() / "sparse", std::span(views_).first(count), {});
  }
  // Writes a photograph, or a share of it.
  void add(std::size_t number, double share = 1) const {
    const std::string& bytes = photographs_[number];
    const auto size = static_cast<std::size_t>(share * static_cast<double>(bytes.size()));
    (void)folder_.with_file("images/" + views_[number].name, bytes.substr(0, size));
  }
  void add_all() const {
    for (std::size_t i = 0; i < views_.size(); ++i) add(i);
  }
  void move_camera(std::size_t number) { views_[number].camera.cam_from_world_translation.x += 0.1; }
  [[nodiscard]] const std::string& name(std::size_t number) const { return views_[number].name; }
  [[nodiscard]] const std::filesystem::path& path() const { return folder_.path(); }

 private:
  TemporaryFolder folder_;
  std::filesystem::path images_ = folder_ / "images";
  std::vector<WrittenView> views_;
  std::vector<std::string> photographs_;
};

// Builds while `act(look, offered)`, called about once for each look at the folder, fills it and says when to end.
struct Watched {
  BuildResult result;
  Names warnings;
};
Watched build_watched(const FillingScene& scene, BuildOptions options,
                      const std::function<bool(std::size_t, std::size_t)>& act) {
  Watched watched;
  std::size_t looks = 0, offered_so_far = 0;
  options.watch.emplace();
  options.watch->interval = std::chrono::milliseconds(1);
  options.watch->end = [&] { return act(looks++, offered_so_far); };
  options.watch->warn = [&](const std::string& sentence) { watched.warnings.push_back(sentence); };
  watched.result = build_model(scene.path(), options, [&](const BuildProgress& progress) {
    if (std::string(progress.stage) == "planning views") offered_so_far = progress.done;
    return true;
  });
  return watched;
}

void check_same_model(const BuildResult& a, const BuildResult& b) {
  CHECK(offered(a) == offered(b));
  CHECK(stored(a) == stored(b));
  CHECK(a.summed_coverage == b.summed_coverage);
  CHECK(a.effective.coverage.ideal_distance == b.effective.coverage.ideal_distance);
  CHECK(a.snapshot.references.views == b.snapshot.references.views);
  CHECK(a.snapshot.vertex_colors == b.snapshot.vertex_colors);
  CHECK(a.snapshot.gains == b.snapshot.gains);
}

// If photographs come one by one, those that leave again take part in refining the others, and so do references that
// are given up later. Refined, all of them fit here.
TEST_CASE("a scene that fills up becomes the model that it would have become with all photographs there at once") {
  const bool refined = GENERATE(false, true);
  BuildOptions options = options_for(refined ? kViews : 8);
  options.sharp_first = false;  // a photograph is offered as it comes, whatever comes later
  options.refine = refined ? RefineMode::joint : RefineMode::none;
  options.refine_lenses = false;
  if (refined) {
    options.planner.coverage.max_references = kViews;
    options.planner.refinement.least_correlation = -1;
  }
  const FillingScene whole, filling;
  whole.add_all();
  const BuildResult plain = build_model(whole.path(), options);
  // One after the other; of the sixth the first half comes some looks before the rest.
  constexpr std::size_t kSlow = 5;
  std::size_t added = 0, looks_at_half = 0;
  const Watched watched = build_watched(filling, options, [&](std::size_t, std::size_t offered) {
    if (offered < added) return false;
    if (added == kSlow && looks_at_half < 6) {
      if (looks_at_half++ == 0) filling.add(kSlow, 0.5);
      return false;
    }
    if (added == kViews) return true;
    filling.add(added++);
    return false;
  });
  CHECK(watched.warnings.empty());
  CHECK(watched.result.views == kViews);
  CHECK(watched.result.skipped.empty());
  check_same_model(watched.result, plain);
}

TEST_CASE("poses that are listed later are taken, also where their file was seen half written") {
  BuildOptions options = options_for(8);
  options.sharp_first = false;
  options.planner.coverage.ideal_distance = 2;  // it would go by the cameras that are listed first
  const FillingScene whole, filling(6);
  whole.add_all();
  filling.add_all();
  const BuildResult plain = build_model(whole.path(), options);
  std::size_t look_of_list = 0;
  const Watched watched = build_watched(filling, options, [&](std::size_t look, std::size_t offered) {
    if (offered == 6 && look_of_list == 0) {
      look_of_list = look;
      filling.list(kViews);
      cut_off(filling.path() / "sparse" / "images.bin");
    }
    if (look_of_list > 0 && look == look_of_list + 5) filling.list(kViews);
    return offered == kViews;
  });
  CHECK(watched.warnings.empty());
  check_same_model(watched.result, plain);
}

TEST_CASE("what stays damaged, never comes or moves is named once, and the others make the model") {
  FillingScene filling;
  for (std::size_t i = 0; i + 1 < kViews; ++i) filling.add(i, i == 3 ? 0.5 : 1);  // the last one never comes
  bool moved = false;
  std::size_t last_look = 0;
  const Watched watched = build_watched(filling, options_for(kViews), [&](std::size_t look, std::size_t offered) {
    if (!moved && offered == kViews - 2) {
      filling.move_camera(0);
      filling.list(kViews);
      moved = true;
      last_look = look + 3 * GrowingScene::kPatience;
    }
    return moved && look > last_look;
  });
  CHECK(watched.result.planned.size() == kViews - 2);
  REQUIRE(watched.result.skipped.size() == 1);
  CHECK(watched.result.skipped.front().name == filling.name(3));
  REQUIRE(watched.warnings.size() == 3);
  CHECK_THAT(watched.warnings[0], Catch::Contains(" 1 photographs that are in use have other poses now"));
  CHECK_THAT(watched.warnings[1], Catch::Contains(filling.name(3) + ": the file is cut off after "));
  CHECK_THAT(watched.warnings[2], Catch::Contains("1 have not come, the first is " + filling.name(kViews - 1)));
}

TEST_CASE("a watched build ends once nothing changes any more, and says so where nothing came") {
  const FillingScene filling;
  BuildOptions options = options_for(8);
  options.watch.emplace();
  options.watch->interval = std::chrono::milliseconds(1);
  options.watch->idle = std::chrono::milliseconds(100);
  CHECK_THROWS_WITH(build_model(filling.path(), options), Catch::Contains("no photograph of the scene has come"));
  filling.add_all();
  CHECK(build_model(filling.path(), options).planned.size() == kViews);
  options.choice = ViewChoice::offline;
  CHECK_THROWS_AS(build_model(filling.path(), options), std::invalid_argument);
  options = options_for(8);
  options.watch.emplace();
  CHECK_THROWS_WITH(build_model(filling.path(), options), "build: watch is given, it must have idle or end");
}

TEST_CASE("what masks take out of photographs is valid in no stored view, refined or not") {
  const TemporaryFolder masks;
  Photograph mask{64, 48, {}, {}};  // the left half is not to be used
  for (int i = 0; i < 64 * 48; ++i) mask.rgb.insert(mask.rgb.end(), 3, i % 64 < 32 ? 0 : 255);
  for (std::uint32_t view = 0; view < kViews; view += 2) {
    write_image(masks / ((view < 10 ? "000" : "00") + std::to_string(view) + ".png"), mask);
  }
  for (const RefineMode refine : {RefineMode::none, RefineMode::all}) {
    BuildOptions options = options_for(kViews);
    options.refine = refine;
    options.pictures.masks = masks.path();
    const BuildResult result = build_model(small_scene(), options);
    CHECK(result.views == kViews);
    CHECK(result.masked_views == kViews / 2);
    std::size_t masked = 0;
    for (const auto& view : result.snapshot.views) {
      if (!view || std::stoi(view->name) % 2 != 0) continue;
      ++masked;
      REQUIRE(view->photograph->valid().size() == 64 * 48);
      for (std::size_t i = 0; i < 64 * 48; ++i) CHECK((view->photograph->valid()[i] == 0) == (i % 64 < 32));
    }
    CHECK(masked > 3);
  }
}

TEST_CASE("the order of the stream changes which views come when, and nothing that is found beforehand") {
  BuildOptions options = options_for(6);
  const BuildResult given = build_model(small_scene(), options);
  options.order = StreamOrder::reversed;
  const BuildResult reversed = build_model(small_scene(), options);
  options.order = StreamOrder::shuffled;
  options.seed = 5;
  const BuildResult shuffled = build_model(small_scene(), options);
  const Names names = offered(given);
  REQUIRE(names.size() == kViews);
  CHECK(std::is_sorted(names.begin(), names.end()));
  CHECK(offered(reversed) == Names(names.rbegin(), names.rend()));
  CHECK(offered(shuffled) != names);
  CHECK(std::is_permutation(names.begin(), names.end(), offered(shuffled).begin()));
  CHECK(offered(shuffled) == offered(build_model(small_scene(), options)));
  for (const BuildResult* other : {&reversed, &shuffled}) {
    CHECK(other->effective.coverage.ideal_distance == given.effective.coverage.ideal_distance);
    CHECK(other->snapshot.surface->cells.size == given.snapshot.surface->cells.size);
  }
}

TEST_CASE("by every choice, the store holds as many views as it may, and those that were chosen") {
  const BuildResult uniform = build_model(small_scene(), options_for(6, ViewChoice::uniform));
  CHECK(stored(uniform) == Names{"0002.png", "0006.png", "0010.png", "0014.png", "0018.png", "0022.png"});
  BuildOptions options = options_for(6, ViewChoice::random);
  const BuildResult random = build_model(small_scene(), options);
  CHECK(stored(random).size() == 6);
  CHECK(stored(random) == stored(build_model(small_scene(), options)));
  options.seed = 1;
  CHECK(stored(random) != stored(build_model(small_scene(), options)));
  const BuildResult offline = build_model(small_scene(), options_for(6, ViewChoice::offline));
  REQUIRE(offline.offline);
  Names chosen;
  for (const std::uint32_t view : offline.offline->choice.views) chosen.push_back(offline.planned[view].name);
  CHECK(stored(offline) == chosen);
  // The planner that stored them, in another order, came to the same coverage.
  CHECK(offline.summed_coverage == Approx(offline.offline->choice.summed_coverage).epsilon(1e-9));
  const BuildResult online = build_model(small_scene(), options_for(6));
  CHECK(stored(online).size() == 6);
  for (const BuildResult* other : {&uniform, &random, &online}) {
    CHECK(offline.summed_coverage >= other->summed_coverage);
    CHECK_FALSE(other->offline);
  }
  CHECK(online.summed_coverage > uniform.summed_coverage);
}

TEST_CASE("a store that all views fit into holds the same by every choice") {
  for (const ViewChoice choice : {ViewChoice::uniform, ViewChoice::random, ViewChoice::offline}) {
    CHECK(stored(build_model(small_scene(), options_for(100, choice))).size() == kViews);
  }
}

TEST_CASE("by every choice, the stored views use up their budget and never exceed it") {
  BuildOptions options = options_for(100);
  options.max_views.reset();
  options.planner.max_bytes = 5 * kBytesPerView + kBytesPerView / 2;
  for (const ViewChoice choice : {ViewChoice::online, ViewChoice::uniform, ViewChoice::random, ViewChoice::offline}) {
    options.choice = choice;
    const BuildResult result = build_model(small_scene(), options);
    CHECK(stored(result).size() == 5);
    CHECK(result.snapshot.views.size() == 5);  // no slot that can never be filled
    CHECK(result.stored_bytes == 5 * kBytesPerView);
    const nlohmann::json totals = summary(result, options);
    CHECK(totals["bytes"]["resident"] == 5 * kBytesPerView);
    CHECK(totals["bytes"]["budget"] <= options.planner.max_bytes);
    CHECK(totals["bytes"]["budget"] > options.planner.max_bytes - 9);
  }
  options.choice = ViewChoice::online;
  options.max_views = 3;  // the tighter bound counts
  CHECK(stored(build_model(small_scene(), options)).size() == 3);
}

bool has_resident_tile_in_every_view(const Snapshot& snapshot) {
  for (std::size_t view = 0; view < snapshot.views.size(); ++view) {
    const auto begin = snapshot.tiles.places.begin() + snapshot.tiles.first_tile[view];
    const auto end = snapshot.tiles.places.begin() + snapshot.tiles.first_tile[view + 1];
    const bool any = std::any_of(begin, end, [](TilePlace slot) { return slot != TilePlace::none; });
    if (any != (snapshot.views[view] != nullptr)) return false;
  }
  return true;
}

TEST_CASE("the texture array of tiles never takes more than its budget, and photographs have theirs") {
  BuildOptions options = options_for(100);
  options.tiles = {16, 2, 0};
  const BuildResult unbounded = build_model(small_scene(), options);
  const std::uint64_t needed = place_bytes(options.tiles) * unbounded.snapshot.tiles.resident_tiles();
  CHECK(summary(unbounded, options)["bytes"]["resident"] == needed);
  CHECK(summary(unbounded, options)["bytes"]["budget"].is_null());
  for (const std::uint64_t share : {2, 5, 50}) {
    options.bound = Bound::of_array(needed / share);
    const BuildResult result = build_model(small_scene(), options);
    const nlohmann::json bytes = summary(result, options)["bytes"];
    // The planner keeps all photographs, so that tiles can be chosen from them; the model holds those with a tile.
    CHECK_FALSE(stored(result).empty());
    CHECK(stored(result).size() <= kViews);
    CHECK(has_resident_tile_in_every_view(result.snapshot));
    CHECK(bytes["budget"] == options.bound.array_bytes());
    CHECK(bytes["resident"] <= options.bound.array_bytes());
    CHECK(bytes["resident"] > options.bound.array_bytes() / 2);
    CHECK(bytes["photographs"] == kViews * kBytesPerView);
  }
  options.planner.max_bytes = 3 * kBytesPerView;
  options.bound = {};
  CHECK(stored(build_model(small_scene(), options)).size() == 3);
  options.bound = Bound::of_array(place_bytes(options.tiles) - 1);
  CHECK_THROWS_WITH(build_model(small_scene(), options), Catch::Contains("must be at least what a tile takes"));
}

TEST_CASE("a budget bounds all that the model takes on the GPU, mesh and tables too, and is used up") {
  BuildOptions options = options_for(100);
  options.tiles = {8, 2, 0};
  options.least_scale = 1;  // tiles alone use it up
  const BuildResult all = build_model(small_scene(), options);
  const std::uint64_t fixed = all.gpu_bytes.sum() - all.gpu_bytes.photographs();
  CHECK(GpuByteCount(all.snapshot.surface).of_surface() <= fixed);
  for (const std::uint64_t share : {2, 30}) {
    options.bound = Bound::of_gpu(fixed + all.gpu_bytes.photographs() / share);
    const BuildResult result = build_model(small_scene(), options);
    CHECK(result.gpu_bytes.sum() <= options.bound.gpu_bytes());
    CHECK(result.gpu_bytes.sum() > options.bound.gpu_bytes() * 9 / 10);
    CHECK(has_resident_tile_in_every_view(result.snapshot));
    const TemporaryFolder folder;
    (void)save_model(result, folder / "model.glb");
    const nlohmann::json saved = inspect_model(folder / "model.glb");
    CHECK(saved["gpu"] == summary(result, options)["gpu"]);
    CHECK(saved["bytes"]["budget"] == options.bound.gpu_bytes());
  }
  options.least_scale = 0;
  CHECK_THROWS_WITH(build_model(small_scene(), options), Catch::Contains("least_scale is 0"));
  options.least_scale = 1;
  options.bound = Bound::of_gpu(GpuByteCount(all.snapshot.surface).of_surface());
  CHECK_THROWS_WITH(build_model(small_scene(), options),
                    Catch::Contains("the mesh and its tables alone take " + std::to_string(options.bound.gpu_bytes())));
}

TEST_CASE("within a budget photographs give up pixels, and no more than they may") {
  BuildOptions options = options_for(100);
  options.tiles = {8, 2, 0};
  const BuildResult all = build_model(small_scene(), options);
  CHECK(all.scale == 1);
  const std::uint64_t fixed = all.gpu_bytes.sum() - all.gpu_bytes.photographs();
  options.bound = Bound::of_gpu(fixed + all.gpu_bytes.photographs() * 2 / 3);
  const BuildResult lowered = build_model(small_scene(), options);
  CHECK(lowered.gpu_bytes.sum() <= options.bound.gpu_bytes());
  CHECK(lowered.scale < 1);
  CHECK(lowered.scale > 0.6);
  CHECK(stored(lowered) == stored(all));
  for (std::size_t slot = 0; slot < all.snapshot.views.size(); ++slot) {
    const Camera& before = all.snapshot.views[slot]->camera;
    const Camera& after = lowered.snapshot.views[slot]->camera;
    CHECK(after.width == std::lround(lowered.scale * before.width));
    CHECK(after.fx / before.fx == Approx(static_cast<double>(after.width) / before.width));
    CHECK(same_pose(before, after));
  }
  options.least_scale = 0.9;
  options.bound = Bound::of_gpu(fixed + all.gpu_bytes.photographs() / 4);
  const BuildResult cut = build_model(small_scene(), options);
  CHECK(cut.scale >= 0.9);
  CHECK(cut.gpu_bytes.sum() <= options.bound.gpu_bytes());
  CHECK(cut.snapshot.tiles.resident_tiles() < all.snapshot.tiles.resident_tiles());
}

TEST_CASE("tiles are compressed only where a budget has no room for the photographs whole") {
  BuildOptions options = options_for(100);
  options.tiles = {8, 2, 0};
  options.tight_tiles = TileOptions{8, 4, 0, TexelFormat::bc7};
  const BuildResult all = build_model(small_scene(), options);
  CHECK(all.snapshot.tiles.options.texels == TexelFormat::rgb8);
  const std::uint64_t whole_views = kViews * TileGrid(64, 48, 8).tiles() * place_bytes(options.tiles);
  options.bound = Bound::of_gpu(GpuByteCount(all.snapshot.surface).of_surface() + whole_views);
  CHECK(build_model(small_scene(), options).snapshot.tiles.options.texels == TexelFormat::rgb8);
  options.bound = Bound::of_gpu(options.bound.gpu_bytes() - 1);
  const BuildResult tight = build_model(small_scene(), options);
  CHECK(tight.snapshot.tiles.options.texels == TexelFormat::bc7);
  CHECK(summary(tight, tight.options)["texels"]["format"] == "bc7");
  CHECK(tight.gpu_bytes.sum() <= options.bound.gpu_bytes());
  options.tiles = kWholeViews;
  CHECK_THROWS_WITH(build_model(small_scene(), options), Catch::Contains("tight_tiles"));
}

TEST_CASE("compressed texels buy more tiles for the same budget, the same ones for any number of threads") {
  BuildOptions options = options_for(100);
  options.tiles = {8, 4, 0};
  options.least_scale = 1;
  const BuildResult all = build_model(small_scene(), options);
  options.bound = Bound::of_gpu(all.gpu_bytes.sum() - all.gpu_bytes.photographs() * 3 / 4);
  const BuildResult plain = build_model(small_scene(), options);
  options.tiles.texels = TexelFormat::bc7;
  const BuildResult packed = build_model(small_scene(), options);
  CHECK(packed.gpu_bytes.sum() <= options.bound.gpu_bytes());
  CHECK(packed.snapshot.tiles.resident_tiles() > plain.snapshot.tiles.resident_tiles() * 3 / 2);
  CHECK(packed.gpu_bytes.masks == packed.gpu_bytes.colors);
  const TemporaryFolder folder;
  (void)save_model(packed, folder / "model.glb");
  CHECK(inspect_model(folder / "model.glb")["gpu"] == summary(packed, options)["gpu"]);
  const tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
  (void)save_model(build_model(small_scene(), options), folder / "single.glb");
  CHECK(read_model(folder / "single.glb").snapshot.tiles.places ==
        read_model(folder / "model.glb").snapshot.tiles.places);
}

TEST_CASE("a view that is larger than the budget is named with its bytes before anything is planned") {
  BuildOptions options = options_for(100);
  options.planner.max_bytes = kBytesPerView - 1;
  CHECK_THROWS_WITH(build_model(small_scene(), options),
                    (small_scene() / "images" / "0000.png").string() +
                        ": takes 30720 bytes in the store, more than the budget of 30719: give at least that as "
                        "--budget");
  options.planner.max_bytes = kBytesPerView;
  CHECK(stored(build_model(small_scene(), options)).size() == 1);
}

TEST_CASE("only photographs that the store holds in the end are read, and one of those that is cut off is named") {
  BuildOptions options = options_for(6);
  options.sharp_first = false;  // which reads all of them
  const TemporaryFolder folder;
  const std::filesystem::path scene = folder / "scene";
  std::filesystem::copy(small_scene(), scene, std::filesystem::copy_options::recursive);
  const BuildResult whole = build_model(scene, options);
  std::vector<std::string> names;
  for (const auto& view : whole.snapshot.views) {
    if (view) names.push_back(view->name);
  }
  REQUIRE(names.size() == 6);
  std::size_t left_again = 0;
  for (const PlannedView& view : whole.planned) {
    const bool in_the_end = std::find(names.begin(), names.end(), view.name) != names.end();
    CHECK((view.read_ms > 0) == in_the_end);
    left_again += !in_the_end && view.verdict.decision != Decision::rejected;
    if (!in_the_end) cut_off(scene / "images" / view.name);
  }
  CHECK(left_again > 0);
  CHECK(stored(build_model(scene, options)) == stored(whole));
  const std::filesystem::path last = scene / "images" / names.back();
  cut_off(last);
  try {
    (void)build_model(scene, options);
    FAIL("a photograph that was cut off was stored");
  } catch (const InputError& error) {
    CHECK_THAT(error.what(), Catch::StartsWith(last.string() + ": "));
  }
}

TEST_CASE("the summary adds up") {
  BuildOptions options = options_for(6);
  options.planner.coverage.max_references = 2;
  const BuildResult result = build_model(small_scene(), options);
  const nlohmann::json totals = summary(result, options);
  const nlohmann::json& views = totals["views"];
  CHECK(views["offered"] == kViews);
  CHECK(views["stored"] == 6);
  CHECK(views["kept"].get<int>() + views["replaced"].get<int>() + views["rejected"].get<int>() +
            views["outliers"].get<int>() ==
        kViews);
  const auto by_references = totals["references_per_cell"].get<std::vector<std::size_t>>();
  REQUIRE(by_references.size() == 3);
  std::size_t cells = 0, references = 0;
  for (std::size_t count = 0; count < by_references.size(); ++count) {
    cells += by_references[count];
    references += count * by_references[count];
  }
  CHECK(totals["cells"] == cells);
  CHECK(totals["references"] == references);
  CHECK(totals["cells_full"] == by_references[2]);
  CHECK(totals["cells_full"] > 0);
  CHECK(totals["cells_referenced"] == cells - by_references[0]);
  CHECK(totals["cells_referenced"].get<std::size_t>() + totals["cells_not_referenced"].get<std::size_t>() +
            totals["cells_never_seen"].get<std::size_t>() ==
        cells);
  CHECK(totals["cells_seen"].get<std::size_t>() + totals["cells_never_seen"].get<std::size_t>() == cells);
  const nlohmann::json& times = totals["time_ms"]["per_view"];
  CHECK(times["visibility"]["views"] == kViews);
  CHECK(times["read"]["views"] == views["stored"]);
  CHECK(times["refine"]["views"] == 0);
  for (const char* const stage : {"visibility", "plan", "read", "store"}) {
    CHECK(times[stage]["median"] > 0);
    CHECK(times[stage]["p95"] >= times[stage]["median"]);
  }
  const std::string text = summary_text(totals, "out");
  CHECK_THAT(text, Catch::StartsWith("out: 6 of 24 views stored (") &&
                       Catch::Contains("; photographs 0.2 MB of 0.2\n") &&
                       Catch::Contains(" seen but not referenced, ") && Catch::Contains("visibility ") &&
                       !Catch::Contains("refine "));
}

TEST_CASE("a model of fewer faces says how many were taken away and how far the surface moved") {
  const auto faces_of = [](const FaceOptions& faces) {
    BuildOptions options = options_for(6);
    options.cells.size = 10;  // so that no face is split for its cell
    options.faces = faces;
    const BuildResult result = build_model(small_scene(), options);
    const nlohmann::json totals = summary(result, options);
    CHECK(totals["faces"]["kept"] == result.snapshot.surface->mesh.faces.size());
    const bool told = summary_text(totals, "out").find("removed, which moved the surface by ") != std::string::npos;
    CHECK(told == (totals["faces"]["taken_away"] > 0));
    return totals["faces"];
  };
  const nlohmann::json all = faces_of({}), few = faces_of({.faces = 500, .pixels = 0}),
                       finely = faces_of({.faces = {}, .pixels = 0.1}), coarsely = faces_of({.faces = {}, .pixels = 2});
  CHECK(all["taken_away"] == 0);
  CHECK(all["moved"] == 0);
  CHECK(few["kept"] <= 500);
  CHECK(few["kept"].get<int>() + few["taken_away"].get<int>() == all["kept"].get<int>());
  CHECK(finely["kept"] < all["kept"]);
  CHECK(coarsely["kept"] < finely["kept"]);
  CHECK(coarsely["moved"] > finely["moved"]);
}

TEST_CASE("the plan tells the coverage after each view, which without demand never falls") {
  BuildOptions options = options_for(6);
  options.planner.coverage.demand = false;
  const BuildResult result = build_model(small_scene(), options);
  const nlohmann::json plan = plan_json(result)["views"];
  REQUIRE(plan.size() == kViews);
  double before = 0;
  for (const nlohmann::json& view : plan) {
    const double now = view["summed_coverage"];
    if (view["decision"] == "rejected") CHECK(now == before);
    if (view["decision"] != "rejected") CHECK(now - before == Approx(view["gain"].get<double>()).margin(1e-9));
    CHECK(view.contains("in_place_of") == (view["decision"] == "replaced"));
    before = now;
  }
  CHECK(before == result.summed_coverage);
}

TEST_CASE("a built model says of each cell how well it is covered") {
  BuildOptions options = options_for(6);
  options.planner.coverage.demand = false;  // so that all cells count alike
  const BuildResult result = build_model(small_scene(), options);
  const Snapshot& snapshot = result.snapshot;
  REQUIRE(snapshot.cell_coverage.size() == snapshot.surface->cells.cells.size());
  double sum = 0;
  for (std::size_t cell = 0; cell < snapshot.cell_coverage.size(); ++cell) {
    sum += static_cast<double>(snapshot.cell_coverage[cell]);
    if (snapshot.cell_coverage[cell] == 0) CHECK(snapshot.references.of_cell(cell).empty());
    if (snapshot.cell_seen[cell] == 0) CHECK(snapshot.cell_coverage[cell] == 0);
  }
  CHECK(sum == Approx(result.summed_coverage).epsilon(1e-5));  // each is rounded to a float
  options.planner.coverage.demand = true;
  const BuildResult with_demand = build_model(small_scene(), options);
  const std::vector<float>& coverage = with_demand.snapshot.cell_coverage;
  CHECK(*std::min_element(coverage.begin(), coverage.end()) >= 0);
  CHECK(*std::max_element(coverage.begin(), coverage.end()) <= 1.0001f);
  CHECK(*std::max_element(coverage.begin(), coverage.end()) > 0.1f);
}

TEST_CASE("the options in effect say all that a build depends on, and name the departures from the print") {
  BuildOptions options = options_for(6, ViewChoice::random);
  options.order = StreamOrder::shuffled;
  options.seed = 9;
  options.planner.max_bytes = 100 * kBytesPerView;
  options.planner.coverage.metric = CoverageOptions::Metric::paper;
  options.planner.coverage.departures = CoverageDepartures::none();
  options.planner.coverage.departures.hemisphere = true;
  const nlohmann::json effective = effective_options(build_model(small_scene(), options), options);
  const nlohmann::json& settings = effective["settings"];
  CHECK(settings["stream.order"] == "shuffled");
  CHECK(settings["stream.choice"] == "random");
  CHECK(settings["stream.seed"] == 9);
  CHECK(effective["budget"] == 100 * kBytesPerView);
  CHECK(effective["max_views"] == 6);
  CHECK(settings["coverage.metric"] == "departures");
  CHECK(settings["departures.hemisphere"] == true);
  CHECK(settings["departures.first-view"] == false);
  CHECK(settings["coverage.ideal-distance"] > 0);
  CHECK(settings["coverage.distance-sigma"] == settings["coverage.ideal-distance"].get<double>() / 2);
  CHECK(settings["tiles.texels"] == "rgb8");  // none of the ways to choose it
  for (const std::string& name : names_of(build_settings())) {
    CAPTURE(name);
    CHECK(settings.contains(name));
  }
  for (const char* const key : {"mesh", "hold_out", "cell_size", "refine"}) {
    CAPTURE(key);
    CHECK(effective.contains(key));
  }
}

TEST_CASE("a bound on the loss takes views away, tells which, and keeps the number of views if one is given") {
  BuildOptions options = options_for(1000);
  options.max_views.reset();
  options.planner.coverage = parsimony_coverage(options.planner.coverage);
  options.planner.coverage.max_references = 64;
  options.planner.max_loss_db = 0;
  const BuildResult all = build_model(small_scene(), options);
  REQUIRE(all.parsimony);
  CHECK(stored(all).size() == kViews);
  CHECK(all.parsimony->predicted.loss_db == 0);
  CHECK(all.parsimony->views == kViews);
  CHECK(all.parsimony->gpu_bytes == all.gpu_bytes.sum());

  options.planner.max_loss_db = 1;
  const BuildResult thinned = build_model(small_scene(), options);
  Names kept;
  for (const PlannedView& view : thinned.planned) {
    if (view.verdict.decision == Decision::kept) kept.push_back(view.name);
  }
  for (const std::string& gone : thinned.parsimony->taken_away) std::erase(kept, gone);
  CHECK(stored(thinned) == kept);
  CHECK(kept.size() < kViews);
  CHECK_FALSE(thinned.parsimony->taken_away.empty());
  CHECK(thinned.parsimony->measured);
  CHECK(thinned.parsimony->loss_db <= 1);
  CHECK(thinned.parsimony->gpu_bytes <= all.gpu_bytes.sum());  // of what the stream has not turned away
  CHECK(thinned.gpu_bytes.sum() < all.gpu_bytes.sum());
  CHECK(thinned.snapshot.references.views.size() < all.snapshot.references.views.size());

  options.max_views = 3;
  const BuildResult few = build_model(small_scene(), options);
  CHECK(stored(few).size() <= 3);
  CHECK(few.parsimony->predicted.short_of_room);
  CHECK(summary(few, options)["parsimony"]["short_of_room"] == true);
  CHECK_THAT(parsimony_text(summary(few, options)["parsimony"]), Catch::Contains("more views were needed than"));

  CHECK_FALSE(build_model(small_scene(), options_for(6)).parsimony);
  options.choice = ViewChoice::uniform;
  CHECK_THROWS_WITH(build_model(small_scene(), options), Catch::Contains("choice must be ViewChoice::online"));
}

TEST_CASE("a build tells of each stage its start, every step and its end, and writes nothing by itself") {
  BuildOptions options = options_for(6, ViewChoice::offline);
  options.refine = RefineMode::joint;
  std::vector<BuildProgress> calls;
  std::ostringstream written;
  std::streambuf* const before = std::cerr.rdbuf(written.rdbuf());
  const BuildResult result = build_model(small_scene(), options, [&](const BuildProgress& progress) {
    calls.push_back(progress);
    return true;
  });
  std::cerr.rdbuf(before);
  CHECK(written.str().empty());
  const auto stage = [&](const std::string& name, std::size_t total, std::size_t steps) {
    CAPTURE(name);
    std::vector<BuildProgress> of_stage;
    for (const BuildProgress& call : calls) {
      if (call.stage == name) of_stage.push_back(call);
    }
    REQUIRE(of_stage.size() == steps + 2);
    for (std::size_t i = 0; i < of_stage.size(); ++i) {
      CHECK(of_stage[i].done == std::min(i, steps));
      CHECK(of_stage[i].total == total);
      CHECK(of_stage[i].finished == (i == steps + 1));
    }
  };
  stage("comparing photographs over the mesh", 0, 0);
  stage("looking past the mesh", 0, 0);
  stage("looking through all cameras", kViews, kViews);
  stage("planning views", kViews, kViews);
  // And one for the lens, which is right.
  const std::size_t steps = result.polish.size() + 1 + (result.poses ? 1 : 0);
  stage("polishing jointly", 0, steps);
  stage("comparing photographs on the surface", 0, 0);
  CHECK(calls.size() == 2 + 2 + 2 * (kViews + 2) + steps + 2 + 2);
}

TEST_CASE("a callback stops a build by returning false, and by an exception of its own") {
  std::size_t calls = 0;
  const auto stopping = [&](const BuildProgress& progress) {
    ++calls;
    return progress.done < 3;
  };
  CHECK_THROWS_AS(build_model(small_scene(), options_for(6), stopping), BuildStopped);
  // Start and end of the comparison and of the look past the mesh, then the start and three steps of the next stage.
  CHECK(calls == 8);
  const auto throwing = [](const BuildProgress&) -> bool { throw std::runtime_error("the battery is low"); };
  CHECK_THROWS_WITH(build_model(small_scene(), options_for(6), throwing), "the battery is low");
}

TEST_CASE("a folder for scratch files that is none is refused before anything is read") {
  BuildOptions options = options_for(6);
  options.memory = {.bytes = 0, .scratch_folder = "/no/such/folder"};
  CHECK_THROWS_WITH(build_model("/no/such/scene", options), Catch::StartsWith("/no/such/folder: is no folder"));
}

TEST_CASE("a model is saved as a folder or as one file, with what tells how it was built, and reads back") {
  BuildOptions options = options_for(6);
  options.hold_out = HoldOut{8, 1};
  const BuildResult result = build_model(small_scene(), options);
  const TemporaryFolder folder;
  for (const char* const name : {"model", "model.glb"}) {
    CAPTURE(name);
    const nlohmann::json totals = save_model(result, folder / name, {.format = ImageFormat::jpeg, .quality = 80});
    const ModelNotes notes = read_model_notes(folder / name);
    CHECK(notes.plan["summary"] == totals);
    CHECK(totals["views"]["offered"] == result.planned.size());
    CHECK(notes.options["image"] == "jpg");
    CHECK(notes.options["quality"] == 80);
    const Model model = read_model(folder / name);
    CHECK(stored(model.snapshot) == stored(result));
  }
  const std::filesystem::path file = folder.with_file("model/tileset.json", "{\"asset\": ,}");
  CHECK_THROWS_WITH(read_model_notes(folder / "model"), Catch::StartsWith(file.string() + ": is not JSON: "));
}

}  // namespace
}  // namespace lumatlas
