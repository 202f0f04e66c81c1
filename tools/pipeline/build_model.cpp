// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/build_model.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>
#include <stdexcept>

#include "blend/egl_context.h"
#include "blend/gl_visibility.h"
#include "mesh/base/errors.h"
#include "planner/tile_choice.h"
#include "tools/base/elapsed.h"
#include "tools/base/interrupt.h"
#include "tools/pipeline/blind_views.h"
#include "tools/pipeline/downscaled_views.h"
#include "tools/pipeline/gpu_budget.h"
#include "tools/pipeline/joint_refinement.h"
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

void note_scene(const SceneViews& scene, BuildResult& result) {
  result.views = scene.views.size();
  result.masked_views = masked_views(scene);
  result.scene_notes = scene.notes;
  result.skipped = skipped_views(scene.views);
}

void note_surface(const SurfaceInput& input, BuildResult& result) {
  result.mesh_file = input.mesh_file;
  result.warnings = input.warnings;
  result.closed_holes = input.closed_holes;
  result.simplified_faces = input.simplified_faces;
  result.simplified_distance = input.simplified_distance;
}

void restrict(RefinementOptions& refinement, RefineMode mode) {
  const bool masks = mode == RefineMode::all || mode == RefineMode::joint;
  refinement.alignment.exposure = refinement.alignment.exposure && (masks || mode == RefineMode::exposure);
  refinement.alignment.pose = refinement.alignment.pose && (masks || mode == RefineMode::pose);
  refinement.trust.enabled = refinement.trust.enabled && masks;
  refinement.interruption_point = throw_if_interrupted;
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

// Gives a view's photograph when it is asked for, and notes how long reading took.
PhotographSource photograph_of(const SceneView& view, PlannedView& planned) {
  return [&view, &planned] {
    const auto start = std::chrono::steady_clock::now();
    Photograph read = load_photograph(view);
    planned.read_ms = ms_since(start);
    return read;
  };
}

PlannedView offer(Planner& planner, const SceneView& view) {
  PlannedView planned;
  planned.name = view.name;
  planned.verdict = planner.offer(view.name, view.camera, photograph_of(view, planned));
  planned.summed_coverage = planner.summed_coverage();
  return planned;
}

void offer_all(Planner& planner, const Stream& stream, const BuildCallback& callback, BuildResult& result) {
  BuildStage stage(callback, "planning views", stream.size());
  for (const SceneView* view : stream) {
    result.planned.push_back(offer(planner, *view));
    stage.tick();
  }
  stage.finish();
}

void keep_chosen(Planner& planner, const Stream& stream, const std::vector<std::size_t>& chosen,
                 const BuildCallback& callback, BuildResult& result) {
  BuildStage stage(callback, "planning views", stream.size());
  for (std::size_t place = 0; place < stream.size(); ++place) {
    const SceneView& view = *stream[place];
    PlannedView planned;
    planned.name = view.name;
    if (std::binary_search(chosen.begin(), chosen.end(), place)) {
      planned.verdict = planner.keep(view.name, view.camera, photograph_of(view, planned));
    } else {
      planner.pass_by(view.camera);
    }
    planned.summed_coverage = planner.summed_coverage();
    result.planned.push_back(std::move(planned));
    stage.tick();
  }
  stage.finish();
}

// Returns the places in the stream of the views that the store would hold at its end, ascending.
std::vector<std::size_t> reserve_all(Planner& planner, const Stream& stream, const BuildCallback& callback,
                                     BuildResult& result) {
  BuildStage stage(callback, "planning views", stream.size());
  for (const SceneView* view : stream) {
    PlannedView planned;
    planned.name = view->name;
    planned.verdict = planner.reserve(view->name, view->camera);
    planned.summed_coverage = planner.summed_coverage();
    result.planned.push_back(std::move(planned));
    stage.tick();
  }
  stage.finish();
  std::vector<std::size_t> places;
  for (std::size_t place = 0; place < stream.size(); ++place) {
    const PlannedView& planned = result.planned[place];
    if (planned.verdict.slot && planner.is_promised(planned.name, *planned.verdict.slot)) places.push_back(place);
  }
  return places;
}

// What outliers left is offered to all the others.
void refill(Planner& planner, const Stream& stream, const std::vector<std::size_t>& filled,
            const BuildCallback& callback, BuildResult& result) {
  BuildStage stage(callback, "planning again", stream.size());
  for (std::size_t place = 0; place < stream.size(); ++place) {
    if (!std::binary_search(filled.begin(), filled.end(), place)) {
      const SceneView& view = *stream[place];
      PlannedView& planned = result.planned[place];
      Verdict verdict = planner.offer_again(view.name, view.camera, photograph_of(view, planned));
      if (verdict.decision != Decision::rejected) planned.verdict = std::move(verdict);
    }
    stage.tick();
  }
  stage.finish();
}

// All cameras are known before the first photograph is read. So the planner goes through them first, and only the
// photographs that are still in the store at the end of the stream are read, refined and stored.
void plan_ahead(Planner& planner, const Stream& stream, const BuildCallback& callback, BuildResult& result) {
  const std::vector<std::size_t> places = reserve_all(planner, stream, callback, result);
  bool outliers = false;
  BuildStage stage(callback, "storing views", places.size());
  for (const std::size_t place : places) {
    PlannedView& planned = result.planned[place];
    planner.fill(planned.name, photograph_of(*stream[place], planned), planned.verdict);
    outliers = outliers || planned.verdict.decision == Decision::outlier;
    stage.tick();
  }
  stage.finish();
  if (outliers) refill(planner, stream, places, callback, result);
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
      result.planned.push_back(offer(planner, *view));
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

// What the views and references that were left out are allowed to lose, dB, but are predicted not to.
double left_of_loss(const BuildResult& result) {
  if (!result.parsimony || !result.effective.max_loss_db) return 0;
  return std::max(0.0, *result.effective.max_loss_db - result.parsimony->predicted.loss_db);
}

void downscale_by_loss(Atlas& atlas, const Visibility& visibility, const BuildCallback& callback, BuildResult& result) {
  const BuildOptions& options = result.options;
  BuildStage stage(callback, "measuring resolutions", 0);
  try {
    const DownscaledViews views = downscale_views_within(options.max_scale_loss_db + left_of_loss(result), atlas,
                                                         visibility, result.effective.validity, options.least_scale);
    result.scale = views.scale;
    result.scale_loss_db = views.loss_db;
  } catch (const GlError& error) {
    add_warning(
        std::string("photographs keep their resolution, for what less would cost cannot be measured: ") + error.what(),
        result);
  }
  stage.finish();
}

// What the model holds of what is stored, within the bounds of bytes and of the loss by resolution.
void take_snapshot(Atlas& atlas, const std::optional<GpuBudget>& budget, const Visibility& visibility,
                   const BuildCallback& callback, BuildResult& result) {
  const BuildOptions& options = result.options;
  ValidityOptions& validity = result.effective.validity;
  if (budget && options.least_scale < 1) {
    result.scale = downscale_views(atlas, *budget, visibility, validity, options.least_scale);
  }
  if (options.max_scale_loss_db > 0 && options.least_scale < 1) {
    downscale_by_loss(atlas, visibility, callback, result);
  }
  validity = validity_at_scale(validity, result.scale);
  result.snapshot = budget ? budget->fitted_snapshot(atlas) : atlas.snapshot();
}

// All but the base texture.
BuildResult choose_and_refine(const std::filesystem::path& scene, const BuildOptions& given,
                              const BuildCallback& callback, const AtlasWatch& watch) {
  BuildResult result;
  result.options = given;
  const BuildOptions& options = result.options;
  MeshInput mesh = load_mesh(scene, options.mesh, options.close_holes);
  std::optional<WatchedScene> watched_scene;
  if (options.watch) watched_scene.emplace(scene, mesh.offset, options.pictures, *options.watch);
  SceneViews views =
      watched_scene ? watched_scene->first_views() : read_scene_views(scene, mesh.offset, options.pictures);
  note_scene(views, result);
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
  note_surface(input, result);
  const std::unique_ptr<Visibility> visibility = make_visibility(*input.surface, options.visibility_by);
  const BlindViews blind = blind_views(views.views, ranks, *visibility);
  if (!options.any_mesh) require_seen(result.mesh_file, blind);
  add_warning(blind_views_warning(blind.blind, blind.looks, blind.first), result);
  restrict(result.effective.refinement, options.refine);
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
  } else if (chosen) {
    keep_chosen(planner, stream, *chosen, callback, result);
  } else if (options.planner.max_loss_db) {
    offer_all(planner, stream, callback, result);
  } else {
    plan_ahead(planner, stream, callback, result);
  }
  if (options.planner.max_loss_db) result.parsimony = thin(planner, stream, atlas.layout(), result.planned);
  result.revisited = planner.revisited();
  refine_jointly(planner, views.views, options, callback, result);
  result.summed_coverage = planner.summed_coverage();
  result.stored_bytes = planner.stored_bytes();
  if (watched) {
    watched.reset();
    atlas.choose_tiles_anew();  // as the first snapshot would
  }
  take_snapshot(atlas, budget, *visibility, callback, result);
  result.gpu_bytes = GpuByteCount(input.surface).of(result.snapshot);
  result.snapshot.cell_coverage = planner.cell_coverage();
  return result;
}

void add_texture(const BuildCallback& callback, BuildResult& result) {
  const auto& views = result.snapshot.views;
  const bool stored = std::any_of(views.begin(), views.end(), [](const auto& view) { return view != nullptr; });
  if (!result.options.texture_px || !stored) return;
  try {
    result.texture = bake_texture(result.snapshot, *result.options.texture_px, callback);
  } catch (const InputError& error) {
    add_warning(std::string("other programs show averaged colours instead of a texture: ") + error.what(), result);
  }
}

}  // namespace

BuildResult build_model(const std::filesystem::path& scene, const BuildOptions& options, const BuildCallback& callback,
                        const AtlasWatch& watch) {
  const auto start = std::chrono::steady_clock::now();
  check(options);
  BuildResult result = choose_and_refine(scene, options, callback, watch);
  add_texture(callback, result);  // with the memory that planning took
  result.total_ms = ms_since(start);
  return result;
}

}  // namespace lumatlas
