// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/build_model.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>
#include <stdexcept>

#include "blend/egl_context.h"
#include "blend/gl_visibility.h"
#include "mesh/base/errors.h"
#include "planner/tile_choice.h"
#include "tools/base/interrupt.h"
#include "tools/pipeline/downscaled_views.h"
#include "tools/pipeline/gpu_budget.h"
#include "tools/pipeline/lens_notes.h"
#include "tools/pipeline/watched_scene.h"
#include "tools/scene/inspection.h"
#include "tools/scene/surface_input.h"

namespace lumatlas {

namespace {

std::vector<Camera> cameras_of(const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks) {
  std::vector<Camera> cameras;
  cameras.reserve(ranks.size());
  for (const std::size_t rank : ranks) cameras.push_back(views[rank].camera);
  return cameras;
}

std::vector<std::size_t> offered_ranks(const SceneViews& scene, const std::optional<HoldOut>& hold_out) {
  std::vector<std::size_t> ranks;
  if (hold_out) {
    ranks = split(scene.views.size(), *hold_out).input;
  } else {
    for (std::size_t rank = 0; rank < scene.views.size(); ++rank) ranks.push_back(rank);
  }
  leave_out_bad(scene, ranks);
  if (ranks.empty()) {
    throw InputError(scene.root.string() + ": none of its " + std::to_string(scene.views.size()) +
                     " views is left to build from: check --hold and --block");
  }
  return ranks;
}

// The views in the order in which they are offered.
using Stream = std::vector<const SceneView*>;

Stream stream_of(const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks) {
  Stream stream;
  stream.reserve(ranks.size());
  for (const std::size_t rank : ranks) stream.push_back(&views[rank]);
  return stream;
}

Stream stream_of(const std::vector<SceneView>& views) {
  Stream stream;
  for (const SceneView& view : views) stream.push_back(&view);
  return stream;
}

void require_room_for_each(const Stream& stream, const BuildOptions& options, std::uint64_t max_bytes) {
  if (max_bytes == 0) return;
  const bool whole_views = options.tiles.whole_views();
  for (const SceneView* view : stream) {
    const std::uint64_t bytes = stored_bytes(view->camera);
    if (bytes <= max_bytes) continue;
    throw InputError(view->image.string() + ": takes " + std::to_string(bytes) + " bytes in the store, more than the " +
                     (whole_views ? "budget of " : "") + std::to_string(max_bytes) +
                     (whole_views ? "" : " for photographs") + ": give at least that as " +
                     (whole_views ? "--budget" : "--photograph-bytes"));
  }
}

// A model is JSON, whose texts are UTF-8: under another name a view could not be found again.
void require_names_that_a_model_can_hold(const Stream& stream) {
  for (const SceneView* view : stream) {
    try {
      (void)nlohmann::json(view->name).dump();
    } catch (const nlohmann::json::type_error&) {
      throw InputError(view->image.string() +
                       ": its name is not UTF-8, which a model needs: rename the photograph, in the scene's list too");
    }
  }
}

// The most views that the store can come to hold: no slot is reserved for what the bounds rule out.
std::uint32_t capacity_for(const Stream& stream, const BuildOptions& options, std::uint64_t budget) {
  std::uint64_t capacity = options.max_views.value_or(~0u);
  if (!options.watch) capacity = std::min<std::uint64_t>(capacity, stream.size());
  if (budget > 0) {
    const auto [least, most] = std::minmax_element(
        stream.begin(), stream.end(),
        [](const SceneView* a, const SceneView* b) { return stored_bytes(a->camera) < stored_bytes(b->camera); });
    const SceneView& measure = options.choice == ViewChoice::online ? **least : **most;
    capacity = std::min(capacity, budget / stored_bytes(measure.camera));
  }
  return static_cast<std::uint32_t>(capacity);
}

// What the photographs would take with all of their tiles, as many of the largest as there may be.
std::uint64_t bytes_of_whole_photographs(const Stream& stream, const BuildOptions& options) {
  std::vector<std::uint64_t> tiles;
  for (const SceneView* view : stream) {
    tiles.push_back(TileGrid(view->camera.width, view->camera.height, options.tiles.tile_px).tiles());
  }
  std::sort(tiles.begin(), tiles.end(), std::greater<>());
  tiles.resize(std::min<std::size_t>(tiles.size(), options.max_views.value_or(~0u)));
  return slot_bytes(options.tiles) * std::accumulate(tiles.begin(), tiles.end(), std::uint64_t{0});
}

// Before the first photograph is stored, because the tiles of the whole store are cut alike.
TileOptions tiles_for_room(const Stream& stream, const BuildOptions& options, const SurfaceInput& input) {
  if (!options.tight_tiles || options.gpu_bytes == 0) return options.tiles;
  const std::uint64_t surface = GpuByteCount(input.surface).of_surface();
  const bool fits = surface + bytes_of_whole_photographs(stream, options) <= options.gpu_bytes;
  return fits && !options.watch ? options.tiles : *options.tight_tiles;
}

TileOptions layout_of(const BuildOptions& options) {
  TileOptions layout = options.tiles;
  if (options.array_bytes > 0) layout.max_tiles = slots_within(options.array_bytes, options.tiles);
  return layout;
}

std::optional<GpuBudget> gpu_budget(const BuildOptions& options, const SurfaceInput& input) {
  if (options.gpu_bytes == 0) return std::nullopt;
  return GpuBudget(options.gpu_bytes, input.surface, options.tiles, input.mesh_file);
}

// With a bound for the photographs that tiles are chosen from, where nobody gave one: at least the largest fits.
PlannerOptions planner_options(const BuildOptions& options, const Stream& stream,
                               const std::optional<GpuBudget>& budget) {
  PlannerOptions planner = options.planner;
  if (budget && planner.max_bytes == 0 && !options.max_views) {
    planner.max_bytes = photograph_bytes_for(budget->room(), options.tiles);
    for (const SceneView* view : stream) planner.max_bytes = std::max(planner.max_bytes, stored_bytes(view->camera));
  }
  return planner;
}

double ms_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

std::unique_ptr<Visibility> make_visibility(const Surface& surface, VisibilityBy by) {
  return by == VisibilityBy::gl ? make_gl_visibility(surface.mesh, surface.cells) : make_ray_visibility(surface.mesh);
}

double median_distance(const std::filesystem::path& mesh_file, const std::vector<Camera>& cameras,
                       const Visibility& visibility) {
  try {
    return median_surface_distance(cameras, visibility);
  } catch (const InputError& error) {
    throw InputError(mesh_file.string() + ": " + error.what());
  }
}

// Views that see next to nothing of the mesh.
struct BlindViews {
  std::size_t looks = 0, blind = 0;
  std::string first;  // by name
};

// Of many views some are looked through, evenly.
BlindViews blind_views(const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks,
                       const Visibility& visibility) {
  constexpr std::size_t kMostLooks = 100;
  constexpr std::uint32_t kGlancePx = 160;  // longer side of the pictures
  const std::size_t step = (ranks.size() + kMostLooks - 1) / kMostLooks;
  BlindViews result;
  VisibilityBuffer buffer;
  for (std::size_t i = 0; i < ranks.size(); i += step, ++result.looks) {
    throw_if_interrupted();
    const SceneView& view = views[ranks[i]];
    visibility.trace(view.camera.shrunk_to(kGlancePx), buffer);
    const auto empty = static_cast<std::size_t>(std::count(buffer.face.begin(), buffer.face.end(), kNoFace));
    const std::size_t seen = buffer.face.size() - empty;
    if (static_cast<double>(seen) >= kLittleSeen * static_cast<double>(buffer.face.size())) continue;
    if (result.blind++ == 0) result.first = view.name;
  }
  return result;
}

// A mesh in other coordinates, or of another scene, is seen by chance.
void require_seen(const std::filesystem::path& mesh_file, const BlindViews& views) {
  if (4 * views.blind <= 3 * views.looks) return;
  throw InputError(mesh_file.string() + ": " + std::to_string(views.blind) + " of " + std::to_string(views.looks) +
                   " views that were looked through see next to nothing of it: mesh and cameras are in different "
                   "coordinates, or the mesh is the wrong one (see lumatlas inspect; --any-mesh builds all the same)");
}

void add_warning(const std::string& sentence, BuildResult& result) {
  if (!sentence.empty()) result.warnings.push_back(sentence);
}

std::vector<SkippedView> skipped_views(const std::vector<SceneView>& views) {
  std::vector<SkippedView> skipped;
  for (const SceneView& view : views) {
    if (!view.bad.empty()) skipped.push_back({view.name, view.bad});
  }
  return skipped;
}

void restrict(RefinementOptions& refinement, RefineMode mode) {
  const bool masks = mode == RefineMode::all || mode == RefineMode::joint;
  refinement.alignment.exposure = refinement.alignment.exposure && (masks || mode == RefineMode::exposure);
  refinement.alignment.pose = refinement.alignment.pose && (masks || mode == RefineMode::pose);
  refinement.trust.enabled = refinement.trust.enabled && masks;
}

OfflinePlan plan_with_hindsight(const Planner& planner, Atlas& atlas, const Stream& stream,
                                const PlannerOptions& options, const BuildCallback& callback) {
  OfflinePlan plan;
  auto start = std::chrono::steady_clock::now();
  std::vector<std::vector<CellPart>> parts;
  BuildStage stage(callback, "looking through all cameras", stream.size());
  for (const SceneView* view : stream) {
    parts.push_back(planner.parts_of(view->camera));
    std::vector<CellPixels> seen;
    for (const CellPart& entry : parts.back()) seen.push_back({entry.cell, 1});
    atlas.mark_seen(seen);
    stage.tick();
  }
  stage.finish();
  plan.look_ms = ms_since(start);
  start = std::chrono::steady_clock::now();
  plan.choice = plan_offline(atlas.surface(), parts, atlas.capacity(),
                             {.coverage = options.coverage,
                              .min_reference_gain = options.min_reference_gain,
                              .interruption_point = throw_if_interrupted});
  plan.choose_ms = ms_since(start);
  return plan;
}

// The places in the stream of the views that are to be stored, ascending; none: the planner decides view by view.
std::optional<std::vector<std::size_t>> chosen_places(const Planner& planner, Atlas& atlas, const Stream& stream,
                                                      const BuildOptions& options, const BuildCallback& callback,
                                                      std::mt19937_64& random, BuildResult& result) {
  switch (options.choice) {
    case ViewChoice::offline: {
      result.offline = plan_with_hindsight(planner, atlas, stream, result.effective, callback);
      const std::vector<std::uint32_t>& views = result.offline->choice.views;
      return std::vector<std::size_t>(views.begin(), views.end());
    }
    case ViewChoice::uniform:
      return evenly_spaced(atlas.capacity(), stream.size());
    case ViewChoice::random:
      return random_choice(atlas.capacity(), stream.size(), random);
    case ViewChoice::online:
      break;
  }
  return std::nullopt;
}

enum class Treatment { offer, keep, pass_by };

PlannedView plan(Planner& planner, const SceneView& view, Treatment treatment) {
  PlannedView planned;
  planned.name = view.name;
  const PhotographSource photograph = [&] {
    const auto start = std::chrono::steady_clock::now();
    Photograph read = load_photograph(view);
    planned.read_ms = ms_since(start);
    return read;
  };
  if (treatment == Treatment::offer) planned.verdict = planner.offer(view.name, view.camera, photograph);
  if (treatment == Treatment::keep) planned.verdict = planner.keep(view.name, view.camera, photograph);
  if (treatment == Treatment::pass_by) planner.pass_by(view.camera);
  planned.summed_coverage = planner.summed_coverage();
  return planned;
}

void run_stream(Planner& planner, const Stream& stream, const std::optional<std::vector<std::size_t>>& chosen,
                const BuildCallback& callback, BuildResult& result) {
  BuildStage stage(callback, "planning views", stream.size());
  for (std::size_t place = 0; place < stream.size(); ++place) {
    Treatment treatment = Treatment::offer;
    if (chosen) {
      const bool is_chosen = std::binary_search(chosen->begin(), chosen->end(), place);
      treatment = is_chosen ? Treatment::keep : Treatment::pass_by;
    }
    result.planned.push_back(plan(planner, *stream[place], treatment));
    stage.tick();
  }
  stage.finish();
}

// Until nothing comes any more. Returns the views that were offered, in that order.
std::vector<SceneView> run_watched(Planner& planner, WatchedScene& scene, const BuildCallback& callback,
                                   BuildResult& result) {
  std::vector<SceneView> offered;
  BuildStage stage(callback, "planning views", 0);
  while (const std::optional<SceneView> view = scene.next()) {
    try {
      const Stream alone{&*view};
      require_names_that_a_model_can_hold(alone);
      require_room_for_each(alone, result.options, result.effective.max_bytes);
      result.planned.push_back(plan(planner, *view, Treatment::offer));
    } catch (const InputError& error) {
      scene.give_back(*view, error.what());  // it may still be being written
      continue;
    }
    offered.push_back(*view);
    stage.tick();
  }
  stage.finish();
  return offered;
}

// What is known of a watched scene at the end of the stream.
void note_watched(WatchedScene& scene, const SceneViews& offered, BuildResult& result) {
  result.views = scene.listed();
  result.scene_notes = scene.notes();
  result.skipped = skipped_views(scene.left_out());
  result.masked_views = masked_views(offered);
}

// What a view would take with all of its tiles resident.
std::uint64_t texels_of(const Camera& camera, const TileOptions& layout) {
  if (layout.whole_views()) return std::uint64_t{camera.width} * camera.height;
  const std::uint64_t tiles = TileGrid(camera.width, camera.height, layout.tile_px).tiles();
  return tiles * layout.slot_px() * layout.slot_px();
}

Parsimony thin(Planner& planner, const Stream& stream, const TileOptions& layout,
               const std::vector<PlannedView>& planned) {
  Parsimony parsimony;
  parsimony.taken_away = planner.thin();
  parsimony.predicted = planner.predicted_loss();
  for (std::size_t place = 0; place < stream.size(); ++place) {
    if (planned[place].verdict.decision == Decision::outlier) continue;
    ++parsimony.views;
    parsimony.references += planned[place].verdict.cells_seen;
    parsimony.texels += texels_of(stream[place]->camera, layout);
  }
  return parsimony;
}

// A step that lowers the mean residual by less than this share is the last.
constexpr double kRestingShare = 0.002;

void polish_until_rest(Planner& planner, const BuildOptions& options, BuildStage& stage, BuildResult& result) {
  double last = std::numeric_limits<double>::infinity();
  for (std::uint32_t step = 0; step < options.max_polish_steps; ++step) {
    result.polish.push_back(planner.polish());
    stage.tick();
    if (result.polish.back().moved_px == 0) break;  // all are where they were given: another step finds the same
    const double residual = result.polish.back().residual_after;
    if (!(residual < (1 - kRestingShare) * last)) break;
    last = residual;
  }
}

// The estimate's time grows with the cube of this: some ten seconds.
constexpr std::uint32_t kMostViewsForLenses = 400;
// Of all views together.
constexpr std::size_t kPointsForLenses = 60000;
constexpr std::size_t kFewestPointsOfView = 300;
// For a first look, which is enough where it shows that no lens is wrong.
constexpr std::size_t kPointsForFirstLook = 4000;
constexpr std::size_t kFewestPointsOfFirstLook = 100;
// Each estimate is exact to first order only, and is made of photographs that the ones before have corrected.
constexpr int kLensRounds = 3;

// Adds what an estimate found to what is known of the lenses.
void note_lenses(const LensEstimates& estimates, std::vector<RefinedLens>& lenses) {
  if (lenses.empty()) {
    for (const LensEstimate& estimate : estimates.lenses) {
      lenses.push_back({estimates.cameras[estimate.slots.front()], estimate.slots.size(), estimate, false});
    }
  }
  for (std::size_t i = 0; i < lenses.size(); ++i) {
    const LensEstimate& estimate = estimates.lenses[i];
    if (!estimate.significant) continue;
    LensEstimate& sum = lenses[i].estimate;
    if (lenses[i].applied) {
      sum.correction = combined(sum.correction, estimate.correction);
      sum.deviation = estimate.deviation;
      sum.residual.after = estimate.residual.after;
      sum.corner_px = corner_move_px(sum.correction, lenses[i].camera);
    }
    lenses[i].applied = true;
  }
}

// Estimates the lenses, undistorts the stored photographs again by those that are plainly wrong, from the originals,
// and polishes; until nothing is wrong any more.
void refine_lenses(Planner& planner, std::vector<SceneView>& views, const BuildOptions& options, BuildStage& stage,
                   BuildResult& result) {
  if (planner.stored_views() == 0 || planner.stored_views() > kMostViewsForLenses) return;
  LensOptions lens_options;
  lens_options.most_points = std::max(kFewestPointsOfFirstLook, kPointsForFirstLook / planner.stored_views());
  if (const LensEstimates first = planner.estimate_lenses(lens_options); !first.undecided()) {
    stage.tick();
    return note_lenses(first, result.lenses);
  }
  lens_options.most_points = std::max(kFewestPointsOfView, kPointsForLenses / planner.stored_views());
  for (int round = 0; round < kLensRounds; ++round) {
    const LensEstimates estimates = planner.estimate_lenses(lens_options);
    stage.tick();
    note_lenses(estimates, result.lenses);
    if (!estimates.significant()) return;
    correct_lenses(views, result.lenses);
    planner.correct_lenses(estimates, [&](std::uint32_t, const std::string& name) {
      return load_photograph(
          *std::find_if(views.begin(), views.end(), [&](const SceneView& v) { return v.name == name; }));
    });
    polish_until_rest(planner, options, stage, result);
  }
}

// What is left to do once the stream has ended.
void finish(Planner& planner, std::vector<SceneView>& views, const BuildOptions& options, const BuildCallback& callback,
            BuildResult& result) {
  const auto start = std::chrono::steady_clock::now();
  if (options.refine == RefineMode::joint) {
    BuildStage stage(callback, "polishing jointly", 0);
    polish_until_rest(planner, options, stage, result);
    if (options.refine_lenses && result.effective.refinement.any()) {
      refine_lenses(planner, views, options, stage, result);
    }
    stage.finish();
  }
  if (result.effective.refinement.trust.enabled) planner.mask();
  result.polish_ms = ms_since(start);
}

void downscale(Atlas& atlas, const Visibility& visibility, const BuildCallback& callback, BuildResult& result) {
  const BuildOptions& options = result.options;
  BuildStage stage(callback, "measuring resolutions", 0);
  try {
    const DownscaledViews views = downscale_views_within(options.max_scale_loss_db, atlas, visibility,
                                                         result.effective.validity, options.least_scale);
    result.scale = views.scale;
    result.scale_loss_db = views.loss_db;
  } catch (const GlError& error) {
    add_warning(
        std::string("photographs keep their resolution, for what less would cost cannot be measured: ") + error.what(),
        result);
  }
  stage.finish();
}

void check_watch(const BuildOptions& options) {
  const auto require = [](bool holds, const char* rule) {
    if (!holds) throw std::invalid_argument(std::string("build: watch is given, ") + rule);
  };
  const WatchOptions& watch = *options.watch;
  require(options.choice == ViewChoice::online, "choice must be ViewChoice::online");
  require(options.order == StreamOrder::given, "order must be StreamOrder::given");
  require(!options.hold_out, "hold_out must not be: it goes by the names of all photographs");
  require(options.max_views || options.planner.max_bytes + options.gpu_bytes > 0,
          "max_views, planner.max_bytes or gpu_bytes must bound the model");
  require(watch.interval.count() > 0, "its interval must be above 0");
  require(watch.idle || watch.end, "it must have idle or end");
  require(!watch.idle || *watch.idle >= watch.interval, "its idle must not be below its interval");
}

}  // namespace

void check(const BuildOptions& options) {
  check(options.cells);
  check(options.faces);
  PlannerOptions planner = options.planner;
  if (planner.coverage.ideal_distance == 0) planner.coverage.ideal_distance = 1;  // any, until the scene gives it
  check(planner);
  if (planner.max_loss_db && options.choice != ViewChoice::online) {
    throw std::invalid_argument("build: planner.max_loss_db is given, choice must be ViewChoice::online");
  }
  if (options.max_polish_steps < 1) throw std::invalid_argument("build: max_polish_steps is 0, must be at least 1");
  if (options.max_views == 0u) throw std::invalid_argument("build: max_views is 0, must be at least 1");
  if (options.hold_out) check(*options.hold_out);
  if (options.watch) check_watch(options);
  check(options.tiles);
  if (options.tight_tiles) {
    check(*options.tight_tiles);
    if (options.tiles.whole_views() || options.tight_tiles->whole_views() || options.tight_tiles->max_tiles != 0) {
      throw std::invalid_argument("build: tight_tiles are given, both they and tiles must cut views, max_tiles be 0");
    }
  }
  if (options.tiles.max_tiles != 0) throw std::invalid_argument("build: tiles.max_tiles is not 0, give array_bytes");
  if (options.tiles.whole_views() && options.array_bytes + options.gpu_bytes > 0) {
    throw std::invalid_argument("build: array_bytes or gpu_bytes is given, but no tiles");
  }
  if (!(options.least_scale > 0 && options.least_scale <= 1)) {
    throw std::invalid_argument("build: least_scale is " + std::to_string(options.least_scale) +
                                ", must be above 0 and at most 1");
  }
  if (!(std::isfinite(options.max_scale_loss_db) && options.max_scale_loss_db >= 0)) {
    throw std::invalid_argument("build: max_scale_loss_db is " + std::to_string(options.max_scale_loss_db) +
                                ", must be finite and not negative");
  }
  if (options.max_scale_loss_db > 0 && !planner.max_loss_db) {
    throw std::invalid_argument("build: max_scale_loss_db is given, planner.max_loss_db must be too");
  }
  if (options.max_scale_loss_db > 0 && options.gpu_bytes > 0) {
    throw std::invalid_argument("build: both max_scale_loss_db and gpu_bytes are given, one alone downscales");
  }
  if (options.array_bytes == 0) return;
  if (options.gpu_bytes > 0) throw std::invalid_argument("build: both array_bytes and gpu_bytes are given");
  if (const std::uint64_t least = slot_bytes(options.tiles); options.array_bytes < least) {
    throw std::invalid_argument("build: array_bytes is " + std::to_string(options.array_bytes) +
                                ", must be at least what a tile takes, " + std::to_string(least));
  }
}

std::uint64_t photograph_bytes_for(std::uint64_t tile_bytes, const TileOptions& tiles) {
  TileOptions uncompressed = tiles;
  uncompressed.texels = TexelFormat::rgb8;
  const double times = static_cast<double>(slot_bytes(uncompressed)) / static_cast<double>(slot_bytes(tiles));
  return static_cast<std::uint64_t>(times * static_cast<double>(kPhotographsPerArray * tile_bytes));
}

BuildResult build_model(const std::filesystem::path& scene, const BuildOptions& given, const BuildCallback& callback,
                        const AtlasWatch& watch) {
  const auto start = std::chrono::steady_clock::now();
  check(given);
  BuildResult result;
  result.options = given;
  const BuildOptions& options = result.options;
  MeshInput mesh = load_mesh(scene, options.mesh, options.close_holes);
  std::optional<WatchedScene> watched_scene;
  if (options.watch) watched_scene.emplace(scene, mesh.offset, options.pictures, *options.watch);
  SceneViews views =
      watched_scene ? watched_scene->first_views() : read_scene_views(scene, mesh.offset, options.pictures);
  result.views = views.views.size();
  result.masked_views = masked_views(views);
  result.scene_notes = views.notes;
  result.skipped = skipped_views(views.views);
  const std::vector<std::size_t> ranks = offered_ranks(views, options.hold_out);
  std::mt19937_64 random(options.seed);
  Stream stream = stream_of(views.views, in_order(ranks, options.order, random));
  require_names_that_a_model_can_hold(stream);
  const SurfaceInput input =
      make_surface(std::move(mesh), options.cells, options.faces, cameras_of(views.views, ranks));
  result.options.tiles = tiles_for_room(stream, options, input);
  const std::optional<GpuBudget> budget = gpu_budget(options, input);
  result.effective = planner_options(options, stream, budget);
  require_room_for_each(stream, options, result.effective.max_bytes);
  result.mesh_file = input.mesh_file;
  result.warnings = input.warnings;
  result.closed_holes = input.closed_holes;
  result.simplified_faces = input.simplified_faces;
  result.simplified_distance = input.simplified_distance;
  const std::unique_ptr<Visibility> visibility = make_visibility(*input.surface, options.visibility_by);
  const BlindViews blind = blind_views(views.views, ranks, *visibility);
  if (!options.any_mesh) require_seen(result.mesh_file, blind);
  add_warning(blind_views_warning(blind.blind, blind.looks, blind.first), result);
  restrict(result.effective.refinement, options.refine);
  result.effective.refinement.interruption_point = throw_if_interrupted;
  if (result.effective.coverage.ideal_distance == 0) {
    // Of the cameras by name, so that it is the same for any order of the stream.
    result.effective.coverage.ideal_distance =
        median_distance(result.mesh_file, cameras_of(views.views, ranks), *visibility);
  }
  Atlas atlas(input.surface, capacity_for(stream, options, result.effective.max_bytes), layout_of(options),
              choose_tiles);
  Planner planner(atlas, *visibility, result.effective);
  std::shared_ptr<void> watched = watch ? watch(atlas) : nullptr;
  const auto chosen = chosen_places(planner, atlas, stream, options, callback, random, result);
  if (watched_scene) {
    views.views = run_watched(planner, *watched_scene, callback, result);
    note_watched(*watched_scene, views, result);
    stream = stream_of(views.views);
  } else {
    run_stream(planner, stream, chosen, callback, result);
  }
  if (options.planner.max_loss_db) result.parsimony = thin(planner, stream, atlas.layout(), result.planned);
  result.revisited = planner.revisited();
  finish(planner, views.views, options, callback, result);
  result.summed_coverage = planner.summed_coverage();
  result.stored_bytes = planner.stored_bytes();
  if (watched) {
    watched.reset();
    atlas.choose_tiles_anew();  // as the first snapshot would
  }
  if (budget && options.least_scale < 1) {
    result.scale = downscale_views(atlas, *budget, *visibility, result.effective.validity, options.least_scale);
  }
  if (options.max_scale_loss_db > 0 && options.least_scale < 1) downscale(atlas, *visibility, callback, result);
  result.effective.validity = validity_at_scale(result.effective.validity, result.scale);
  result.snapshot = budget ? budget->fitted_snapshot(atlas) : atlas.snapshot();
  result.gpu_bytes = GpuByteCount(input.surface).of(result.snapshot);
  result.snapshot.cell_coverage = planner.cell_coverage();
  result.total_ms = ms_since(start);
  return result;
}

}  // namespace lumatlas
