// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/views/planned_views.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "atlas/images/pixel_memory.h"
#include "blend/gl_visibility.h"
#include "planner/refinement/surface_deviation.h"
#include "planner/tile_choice.h"
#include "tools/base/elapsed.h"
#include "tools/base/process/interrupt.h"
#include "tools/budget/downscaled_views.h"
#include "tools/budget/fitted_views.h"
#include "tools/budget/gpu_budget.h"
#include "tools/pipeline/refinement/joint_refinement.h"
#include "tools/pipeline/refinement/lens_notes.h"
#include "tools/pipeline/refinement/stream_refinement.h"
#include "tools/pipeline/views/parsimony.h"

namespace lumatlas {

namespace {

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

TileOptions layout_of(const BuildOptions& options) {
  TileOptions layout = options.tiles;
  if (options.bound.array_bytes() > 0) layout.max_tiles = places_within(options.bound.array_bytes(), options.tiles);
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
    planner.max_bytes = photograph_bytes_for(budget->bytes_left(), options.tiles);
    for (const SceneView* view : stream) planner.max_bytes = std::max(planner.max_bytes, stored_bytes(view->camera));
  }
  return planner;
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
  refinement.cancel_check = between_steps;
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
                              .cancel_check = throw_if_interrupted});
  plan.choose_ms = ms_since(start);
  return plan;
}

// Returns the places in the stream of the views to store, ascending; none: the planner decides view by view.
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
  SurfaceDeviation deviation = surface_deviation(result.snapshot, {.cancel_check = between_steps});
  if (deviation.any_measured()) {
    result.trust = trust_shares(result.snapshot, deviation, visibility);
    result.snapshot.cell_deviation = std::move(deviation.of_cell);
  }
  stage.finish();
}

}  // namespace

std::vector<SkippedView> skipped_views(const std::vector<SceneView>& views) {
  std::vector<SkippedView> skipped;
  for (const SceneView& view : views) {
    if (!view.bad.empty()) skipped.push_back({view.name, view.bad});
  }
  return skipped;
}

std::shared_ptr<const Visibility> make_visibility(const Surface& surface, VisibilityBy by) {
  return by == VisibilityBy::gl ? make_gl_visibility(surface.mesh, surface.cells) : make_ray_visibility(surface.mesh);
}

void plan_views(const PlanningInput& input, const BuildCallback& callback, const AtlasWatch& watch,
                BuildResult& result) {
  const BuildOptions& options = result.options;
  std::vector<SceneView>& views = input.views.views;
  Stream stream = input.stream;
  const std::shared_ptr<const Surface> surface = input.seen.input.surface;
  const std::optional<GpuBudget> budget = gpu_budget(options, input.seen.input);
  result.effective = planner_options(options, stream, budget);
  require_room_for_each(stream, options, result.effective.max_bytes);
  restrict(result.effective.refinement, options.refine);
  result.effective.coverage.ideal_distance = input.usual_distance;
  Atlas atlas(surface, capacity_for(stream, options, result.effective.max_bytes), layout_of(options), choose_tiles);
  Planner planner(atlas, *input.seen.visibility, result.effective);
  StreamRefinement refinement(planner, views, result.lenses, options);
  Streaming streaming(planner, refinement, callback, result);
  std::shared_ptr<void> watched = watch ? watch(atlas) : nullptr;
  const auto chosen = chosen_places(planner, atlas, stream, options, callback, input.random, result);
  if (input.watched != nullptr) {
    streaming.run_watched(*input.watched, views);
    note_watched(*input.watched, input.views, result);
    stream = stream_of(views);
  } else if (chosen) {
    streaming.keep_chosen(stream, *chosen);
  } else if (options.planner.max_loss_db) {
    streaming.offer_all(stream);
  } else {
    streaming.plan_ahead(stream, options.sharp_first && stream.size() > atlas.capacity() &&
                                     options.planner.coverage.metric == CoverageOptions::Metric::directions);
  }
  refinement.finish(callback);
  result.revisited = planner.refiner().revisited();
  refine_jointly(planner, views, options, callback, result);
  if (options.planner.max_loss_db) {
    const auto look = [&](const Surface& seen) { return make_visibility(seen, options.visibility_by); };
    give_up_within_loss(planner, atlas, input.seen, look, stream, callback, result);
  }
  count_views(atlas, result.lenses);
  result.summed_coverage = planner.store().summed_coverage();
  result.stored_bytes = planner.store().stored_bytes();
  if (watched) {
    watched.reset();
    atlas.choose_tiles_anew();  // the first snapshot would choose them so
  }
  if (budget) fit_within(*budget, planner, atlas, *input.seen.visibility, callback, result);
  if (input.last_change) input.last_change(atlas);
  take_snapshot(atlas, budget, result);
  result.gpu_bytes = GpuByteCount(input.seen.input.surface).of(result.snapshot);
  result.snapshot.cell_coverage = planner.store().cell_coverage();
  measure_deviation(*input.seen.visibility, callback, result);
}

}  // namespace lumatlas
