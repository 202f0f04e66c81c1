// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/build_model.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <numeric>
#include <random>
#include <stdexcept>

#include "atlas/images/pixel_memory.h"
#include "blend/gl_visibility.h"
#include "mesh/base/errors.h"
#include "planner/refinement/surface_deviation.h"
#include "planner/surface_distance.h"
#include "planner/tile_choice.h"
#include "tools/base/elapsed.h"
#include "tools/base/process/interrupt.h"
#include "tools/budget/downscaled_views.h"
#include "tools/budget/fewer_faces.h"
#include "tools/budget/fitted_views.h"
#include "tools/budget/gpu_budget.h"
#include "tools/inspection/blind_views.h"
#include "tools/inspection/mesh_diagnosis.h"
#include "tools/pipeline/parsimony.h"
#include "tools/pipeline/refinement/joint_refinement.h"
#include "tools/pipeline/refinement/lens_notes.h"
#include "tools/pipeline/refinement/lens_refinement.h"
#include "tools/pipeline/streaming.h"
#include "tools/pipeline/watched_scene.h"
#include "tools/surface/surface_input.h"

namespace lumatlas {

namespace {

std::vector<Camera> cameras_of(const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks) {
  std::vector<Camera> cameras;
  cameras.reserve(ranks.size());
  for (const std::size_t rank : ranks) cameras.push_back(views[rank].camera);
  return cameras;
}

std::vector<std::size_t> offered_ranks(const SceneViews& scene, const std::optional<HoldOut>& hold_out) {
  std::vector<std::size_t> ranks = split(scene, hold_out).input;
  if (ranks.empty()) {
    throw InputError(scene.root.string() + ": none of its " + std::to_string(scene.views.size()) +
                     " views is left to build from: check --hold and --block");
  }
  return ranks;
}

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

// Returns the bytes of the photographs with all of their tiles, for as many of the largest as there may be.
std::uint64_t bytes_of_whole_photographs(const Stream& stream, const BuildOptions& options) {
  std::vector<std::uint64_t> tiles;
  for (const SceneView* view : stream) {
    tiles.push_back(TileGrid(view->camera.width, view->camera.height, options.tiles.tile_px).tiles());
  }
  std::sort(tiles.begin(), tiles.end(), std::greater<>());
  tiles.resize(std::min<std::size_t>(tiles.size(), options.max_views.value_or(~0u)));
  return slot_bytes(options.tiles) * std::accumulate(tiles.begin(), tiles.end(), std::uint64_t{0});
}

// Returns whether the bytes of the GPU have room for all that the stream may bring.
bool all_fits(const Stream& stream, const BuildOptions& options, const SurfaceInput& input) {
  if (options.watch) return false;  // who knows
  return GpuByteCount(input.surface).of_surface() + bytes_of_whole_photographs(stream, options) <=
         options.bound.gpu_bytes();
}

// Before the first photograph is stored, because the tiles of the whole store are cut alike, and seen on one mesh.
void make_room(const Stream& stream, BuildOptions& options, SurfaceInput& input) {
  if (options.bound.gpu_bytes() == 0 || all_fits(stream, options, input)) return;
  if (options.tight_tiles) options.tiles = *options.tight_tiles;
  if (options.faces.pixels > 0) {
    const std::uint64_t photographs =
        options.watch ? options.bound.gpu_bytes() : bytes_of_whole_photographs(stream, options);
    input = with_room_for_photographs(input, options.cells, options.bound.gpu_bytes(), photographs);
  }
}

TileOptions layout_of(const BuildOptions& options) {
  TileOptions layout = options.tiles;
  if (options.bound.array_bytes() > 0) layout.max_tiles = slots_within(options.bound.array_bytes(), options.tiles);
  return layout;
}

std::optional<GpuBudget> gpu_budget(const BuildOptions& options, const SurfaceInput& input) {
  if (options.bound.gpu_bytes() == 0) return std::nullopt;
  return GpuBudget(options.bound.gpu_bytes(), input.surface, options.tiles, input.mesh_file);
}

// Bounds the photographs that tiles are chosen from if the options do not: at least the largest fits.
PlannerOptions planner_options(const BuildOptions& options, const Stream& stream,
                               const std::optional<GpuBudget>& budget) {
  PlannerOptions planner = options.planner;
  if (budget && planner.max_bytes == 0 && !options.max_views) {
    planner.max_bytes = photograph_bytes_for(budget->room(), options.tiles);
    for (const SceneView* view : stream) planner.max_bytes = std::max(planner.max_bytes, stored_bytes(view->camera));
  }
  return planner;
}

std::shared_ptr<const Visibility> make_visibility(const Surface& surface, VisibilityBy by) {
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
  result.listed_to_score = held_out_views(scene);
  result.masked_views = masked_views(scene);
  result.scene_notes = scene.notes;
  result.georeference = scene.georeference;
  result.skipped = skipped_views(scene.views);
}

void note_surface(const SurfaceInput& input, BuildResult& result) {
  result.closed_holes = input.closed_holes;
  result.simplified_faces = input.simplified_faces;
  result.simplified_distance = input.simplified_distance;
}

// Tells what does not fit. Lenses are then taken as given: what a wrong mesh pretends is no lens. Black borders are
// left out, before they are painted on the surface or taken for a lens.
void diagnose(const std::filesystem::path& scene, const MeshInput& mesh, const Visibility& visibility,
              std::vector<SceneView>& views, const std::vector<std::size_t>& ranks, const BuildCallback& callback,
              BuildResult& result) {
  BuildStage stage(callback, "comparing photographs over the mesh", 0);
  result.fit = diagnose_mesh(scene, mesh.facts, mesh.mesh, mesh.offset, visibility, views, ranks);
  for (const std::string& sentence : result.fit->warnings) add_warning(sentence, result);
  if (!result.fit->likely.empty()) result.options.refine_lenses = false;
  if (result.fit->black_border > 0) leave_out_black_rims(views);
  stage.finish();
}

// Looks at the mesh as it was given, and tells what is wrong with it.
void judge(const std::filesystem::path& scene, const MeshInput& mesh, std::vector<SceneView>& views,
           const std::vector<std::size_t>& ranks, const BuildCallback& callback, BuildResult& result) {
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(mesh.mesh);
  const BlindViews blind = blind_views(views, ranks, *visibility);
  if (!result.options.watch) diagnose(scene, mesh, *visibility, views, ranks, callback, result);
  if (!result.options.any_mesh) {
    if (result.fit && !result.options.mesh_frame) require_right_frame(*result.fit);
    require_seen(result.mesh_file, blind, result.fit ? result.fit->likely : "");
  }
  add_warning(blind_views_warning(blind.blind, blind.looks, blind.first), result);
}

// Adds to the mesh what it lacks, and returns its far sphere, by which coverage counts only with demand: it is at no
// distance that a view could be ideal at. A mesh that does not fit the photographs stays as it is.
FarSphere complete(const std::filesystem::path& scene, const SceneViews& views, const std::vector<std::size_t>& ranks,
                   const BuildCallback& callback, MeshInput& mesh, BuildResult& result) {
  if (result.options.watch || (result.fit && !result.fit->likely.empty())) return {};
  CompletionOptions options = result.options.completion;
  options.far_sphere = options.far_sphere && has_demand(result.options.planner.coverage);
  CompletedSurface completed = complete_surface(scene, views, ranks, options, callback, mesh);
  result.frames = completed.shares;
  result.added_faces = completed.added_faces;
  result.removed = {completed.contradicted.faces.size(), completed.contradicted.groups, completed.contradicted.pixels};
  for (const std::string& sentence : completed.warnings) add_warning(sentence, result);
  add_warning(filled_frames_warning(completed.shares), result);
  return std::move(completed.far);
}

// Called between steps that read photographs.
void between_steps() {
  throw_if_interrupted();
  give_back_scratch_pages();
}

void restrict(RefinementOptions& refinement, RefineMode mode) {
  const bool masks = mode == RefineMode::all || mode == RefineMode::joint;
  refinement.alignment.exposure = refinement.alignment.exposure && (masks || mode == RefineMode::exposure);
  refinement.alignment.pose = refinement.alignment.pose && (masks || mode == RefineMode::pose);
  refinement.trust.enabled = refinement.trust.enabled && masks;
  refinement.interruption_point = between_steps;
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
  plan.choice = plan_offline(*atlas.surface(), parts, atlas.capacity(),
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

// Adds the facts of a watched scene at the end of the stream.
void note_watched(WatchedScene& scene, const SceneViews& offered, BuildResult& result) {
  result.views = scene.listed();
  result.scene_notes = scene.notes(offered.views);
  result.skipped = skipped_views(scene.left_out());
  result.masked_views = masked_views(offered);
}

// Photographs in the bytes that there are for them.
void fit_within(const GpuBudget& budget, const Planner& planner, Atlas& atlas, const Visibility& visibility,
                const BuildCallback& callback, BuildResult& result) {
  BuildStage stage(callback, "measuring what can be given up", 0);
  const FittedViews fitted =
      fit_views(budget, result.options.least_scale, planner, atlas, visibility, result.effective.validity, stage);
  result.scale = fitted.scale;
  result.fitted_loss = fitted.loss;
  if (!fitted.not_measured.empty()) {
    result.warnings.push_back(
        "photographs are downscaled until all fit or they are at budget.least-scale, for what that costs "
        "cannot be measured: " +
        fitted.not_measured);
  }
  stage.finish();
}

// Takes the snapshot that the model holds.
void take_snapshot(Atlas& atlas, const std::optional<GpuBudget>& budget, BuildResult& result) {
  ValidityOptions& validity = result.effective.validity;
  validity = validity_at_scale(validity, result.scale);
  result.snapshot = budget ? budget->fitted_snapshot(atlas) : atlas.snapshot();
}

// Measures the deviation of the surface. The snapshot gets none where no two photographs can be compared.
void measure_deviation(const Visibility& visibility, const BuildCallback& callback, BuildResult& result) {
  if (!result.options.measure_deviation) return;
  BuildStage stage(callback, "comparing photographs on the surface", 0);
  SurfaceDeviation deviation = surface_deviation(result.snapshot, {.interruption_point = between_steps});
  if (deviation.any_measured()) {
    result.trust = trust_shares(result.snapshot, deviation, visibility);
    result.snapshot.cell_deviation = std::move(deviation.of_cell);
  }
  stage.finish();
}

// All but the base texture.
BuildResult choose_and_refine(const std::filesystem::path& scene, const BuildOptions& given,
                              const BuildCallback& callback, const AtlasWatch& watch) {
  BuildResult result;
  result.options = given;
  const BuildOptions& options = result.options;
  MeshInput mesh = load_mesh(scene, options.mesh, options.close_holes, options.mesh_frame.value_or(MeshFrame{}));
  std::optional<WatchedScene> watched_scene;
  if (options.watch) watched_scene.emplace(scene, mesh.offset, options.pictures, *options.watch);
  SceneViews views =
      watched_scene ? watched_scene->first_views() : read_scene_views(scene, mesh.offset, options.pictures);
  note_scene(views, result);
  const std::vector<std::size_t> ranks = offered_ranks(views, options.hold_out);
  std::mt19937_64 random(options.seed);
  Stream stream = stream_of(views.views, in_order(ranks, options.order, random));
  require_names_that_a_model_can_hold(stream);
  SeenSurface seen;
  SurfaceInput& input = seen.input;
  result.mesh_file = mesh.facts.mesh_file;
  result.warnings = mesh.facts.warnings;
  judge(scene, mesh, views.views, ranks, callback, result);
  const FarSphere far = complete(scene, views, ranks, callback, mesh, result);
  const std::vector<Camera> cameras =
      cameras_of(views.views, ranks);  // sorted by name, the same for any order of the stream
  input = make_surface(std::move(mesh), options.cells, options.faces, cameras);
  make_room(stream, result.options, input);
  note_surface(input, result);
  seen.visibility = make_visibility(*input.surface, options.visibility_by);
  double usual_distance = options.planner.coverage.ideal_distance;
  if (usual_distance == 0) usual_distance = median_distance(result.mesh_file, cameras, *seen.visibility);
  if (!far.mesh.faces.empty()) {
    input.surface = std::make_shared<const Surface>(with_far_sphere(*input.surface, far));
    seen.visibility = make_visibility(*input.surface, options.visibility_by);
  }
  const std::optional<GpuBudget> budget = gpu_budget(options, input);
  result.effective = planner_options(options, stream, budget);
  require_room_for_each(stream, options, result.effective.max_bytes);
  restrict(result.effective.refinement, options.refine);
  result.effective.coverage.ideal_distance = usual_distance;
  Atlas atlas(input.surface, capacity_for(stream, options, result.effective.max_bytes), layout_of(options),
              choose_tiles);
  Planner planner(atlas, *seen.visibility, result.effective);
  StreamRefinement refinement(planner, views.views, result.lenses, options);
  Streaming streaming(planner, refinement, callback, result);
  std::shared_ptr<void> watched = watch ? watch(atlas) : nullptr;
  const auto chosen = chosen_places(planner, atlas, stream, options, callback, random, result);
  if (watched_scene) {
    streaming.run_watched(*watched_scene, views.views);
    note_watched(*watched_scene, views, result);
    stream = stream_of(views.views);
  } else if (chosen) {
    streaming.keep_chosen(stream, *chosen);
  } else if (options.planner.max_loss_db) {
    streaming.offer_all(stream);
  } else {
    streaming.plan_ahead(stream);
  }
  refinement.finish(callback);
  result.revisited = planner.refiner().revisited();
  refine_jointly(planner, views.views, options, callback, result);
  if (options.planner.max_loss_db) {
    const auto look = [&](const Surface& surface) { return make_visibility(surface, options.visibility_by); };
    give_up_within_loss(planner, atlas, seen, look, stream, callback, result);
  }
  count_views(atlas, result.lenses);
  result.summed_coverage = planner.store().summed_coverage();
  result.stored_bytes = planner.store().stored_bytes();
  if (watched) {
    watched.reset();
    atlas.choose_tiles_anew();  // the first snapshot would choose them so
  }
  if (budget) fit_within(*budget, planner, atlas, *seen.visibility, callback, result);
  take_snapshot(atlas, budget, result);
  result.gpu_bytes = GpuByteCount(input.surface).of(result.snapshot);
  result.snapshot.cell_coverage = planner.store().cell_coverage();
  measure_deviation(*seen.visibility, callback, result);
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
  const auto memory = std::make_shared<const PixelMemoryBound>(
      options.memory.bytes.value_or(usual_pixel_memory()),
      options.memory.scratch_folder.empty() ? std::filesystem::temp_directory_path() : options.memory.scratch_folder);
  BuildResult result = choose_and_refine(scene, options, callback, watch);
  result.memory = memory;
  add_texture(callback, result);  // with the memory that planning took
  result.scratch_bytes = pixel_memory().in_files;
  result.total_ms = ms_since(start);
  return result;
}

}  // namespace lumatlas
