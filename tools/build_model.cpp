// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/build_model.h"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "blend/gl_visibility.h"
#include "mesh/errors.h"
#include "tools/percentile.h"
#include "tools/photograph_stream.h"
#include "tools/progress.h"
#include "tools/refinement_json.h"
#include "tools/surface_input.h"

namespace lumatlas {

namespace {

using nlohmann::json;

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
  if (ranks.empty()) {
    throw InputError(scene.root.string() + ": none of its " + std::to_string(scene.views.size()) +
                     " views is left to build from: check --hold and --block");
  }
  return ranks;
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

json spread(const std::vector<double>& values) {
  if (values.empty()) return {{"median", 0}, {"p95", 0}};
  return {{"median", percentile(values, 0.5)}, {"p95", percentile(values, 0.95)}};
}

json spread_of(const std::vector<PlannedView>& planned, double Verdict::*field) {
  std::vector<double> values;
  values.reserve(planned.size());
  for (const PlannedView& view : planned) values.push_back(view.verdict.*field);
  return spread(values);
}

std::size_t count(const std::vector<PlannedView>& planned, Decision decision) {
  return static_cast<std::size_t>(std::count_if(
      planned.begin(), planned.end(), [&](const PlannedView& view) { return view.verdict.decision == decision; }));
}

std::uint64_t peak_resident_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

const char* name_of(Decision decision) {
  switch (decision) {
    case Decision::kept:
      return "kept";
    case Decision::replaced:
      return "replaced";
    case Decision::outlier:
      return "outlier";
    case Decision::rejected:
      break;
  }
  return "rejected";
}

void restrict(RefinementOptions& refinement, RefineMode mode) {
  const bool masks = mode == RefineMode::all || mode == RefineMode::joint;
  refinement.alignment.exposure = refinement.alignment.exposure && (masks || mode == RefineMode::exposure);
  refinement.alignment.pose = refinement.alignment.pose && (masks || mode == RefineMode::pose);
  refinement.trust.enabled = refinement.trust.enabled && masks;
}

// A step that lowers the mean residual by less than this share is the last.
constexpr double kRestingShare = 0.002;

// The estimate's time grows with the cube of this: some ten seconds.
constexpr std::uint32_t kMostViewsForIntrinsics = 400;

// A radial coefficient is only reported: photographs would have to be warped again. What the others are without it is
// estimated anew, because they make up for each other.
void consider_intrinsics(Planner& planner, IntrinsicsUse use, BuildResult& result) {
  if (use == IntrinsicsUse::ignore || !result.effective.refinement.any()) return;
  if (planner.stored_views() > kMostViewsForIntrinsics) return;
  result.intrinsics = planner.estimate_intrinsics();
  if (use != IntrinsicsUse::apply || !result.intrinsics->significant) return;
  const IntrinsicsEstimate pinhole = planner.estimate_intrinsics({.radial = false});
  if (!pinhole.significant) return;
  planner.set_cameras(pinhole);
  planner.polish();
  result.intrinsics_applied = true;
}

// What is left to do once the stream has ended.
void finish(Planner& planner, const BuildOptions& options, BuildResult& result) {
  const auto start = std::chrono::steady_clock::now();
  if (options.refine == RefineMode::joint) {
    Progress progress("polishing jointly", 0, ProgressOptions::standard_error(options.quiet));
    double last = std::numeric_limits<double>::infinity();
    for (std::uint32_t step = 0; step < options.max_polish_steps; ++step) {
      result.polish.push_back(planner.polish());
      progress.tick();
      const double residual = result.polish.back().residual_after;
      if (!(residual < (1 - kRestingShare) * last)) break;
      last = residual;
    }
  }
  consider_intrinsics(planner, options.intrinsics, result);
  if (result.effective.refinement.trust.enabled) planner.mask();
  result.polish_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// Pixels of all stored views, and of a full store of the largest of them.
struct Texels {
  std::uint64_t resident = 0;
  std::uint64_t largest = 0;
};
Texels texels_of(const Snapshot& snapshot) {
  Texels texels;
  for (const auto& view : snapshot.views) {
    if (!view) continue;
    const std::uint64_t pixels = std::uint64_t{view->camera.width} * view->camera.height;
    texels.resident += pixels;
    texels.largest = std::max(texels.largest, pixels);
  }
  return texels;
}

json intrinsics_json(const BuildResult& result) {
  if (!result.intrinsics) return nullptr;
  const IntrinsicsEstimate& e = *result.intrinsics;
  const auto parameters = [](const Intrinsics& i) -> json {
    return {{"focal", i.focal}, {"principal_px", {i.principal.x, i.principal.y}}, {"radial", i.radial}};
  };
  return {{"correction", parameters(e.correction)},
          {"deviation", parameters(e.deviation)},
          {"residual", {{"before", e.residual_before}, {"after", e.residual_after}}},
          {"corner_px", e.corner_px},
          {"views", e.views},
          {"points", e.points},
          {"significant", e.significant},
          {"applied", result.intrinsics_applied}};
}

std::string printed(const char* format, double value) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

}  // namespace

std::string intrinsics_advice(const IntrinsicsEstimate& estimate, bool applied) {
  if (!estimate.significant) return {};
  const Intrinsics& c = estimate.correction;
  const std::string radial = printed("%.4f", c.radial);
  return "The photographs agree better with a focal length " + printed("%.2f %% ", 100 * std::abs(c.focal - 1)) +
         (c.focal < 1 ? "shorter" : "longer") + ", the principal point moved by (" + printed("%.1f", c.principal.x) +
         ", " + printed("%.1f", c.principal.y) + ") px and a radial coefficient of " + radial + " (a corner moves " +
         printed("%.1f", estimate.corner_px) + " px; residual " + printed("%.4f", estimate.residual_before) + " -> " +
         printed("%.4f", estimate.residual_after) + "): " +
         (applied ? "focal length and principal point were applied, the radial coefficient was not, because the "
                    "photographs would have to be undistorted again."
                  : "refine the cameras in the structure-from-motion program, or give --refine-intrinsics.");
}

void check(const BuildOptions& options) {
  check(options.cells);
  PlannerOptions planner = options.planner;
  if (planner.coverage.ideal_distance == 0) planner.coverage.ideal_distance = 1;  // any, until the scene gives it
  check(planner);
  if (options.max_polish_steps < 1) throw std::invalid_argument("build: max_polish_steps is 0, must be at least 1");
  if (options.max_views < 1) throw std::invalid_argument("build: max_views is 0, must be at least 1");
  if (options.hold_out) check(*options.hold_out);
}

BuildResult build_model(const std::filesystem::path& scene, const BuildOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  check(options);
  BuildResult result;
  const SurfaceInput input = load_surface(scene, options.mesh, options.cells);
  result.mesh_file = input.mesh_file;
  const SceneViews views = read_scene_views(scene, input.surface->offset);
  const std::vector<std::size_t> ranks = offered_ranks(views, options.hold_out);
  const std::unique_ptr<Visibility> visibility = make_visibility(*input.surface, options.visibility_by);
  result.effective = options.planner;
  restrict(result.effective.refinement, options.refine);
  if (result.effective.coverage.ideal_distance == 0) {
    result.effective.coverage.ideal_distance =
        median_distance(result.mesh_file, cameras_of(views.views, ranks), *visibility);
  }
  // A store larger than the stream would only hold empty slots.
  Atlas atlas(input.surface, std::min(options.max_views, static_cast<std::uint32_t>(ranks.size())));
  Planner planner(atlas, *visibility, result.effective);
  {
    Progress progress("planning views", ranks.size(), ProgressOptions::standard_error(options.quiet));
    PhotographStream photographs(views.views, ranks);
    for (const std::size_t rank : ranks) {
      const SceneView& view = views.views[rank];
      result.planned.push_back({view.name, planner.offer(view.name, view.camera, photographs.next())});
      progress.tick();
    }
  }
  finish(planner, options, result);
  result.summed_coverage = planner.summed_coverage();
  result.snapshot = atlas.snapshot();
  result.total_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return result;
}

json summary(const BuildResult& result, const BuildOptions& options) {
  const Texels texels = texels_of(result.snapshot);
  constexpr std::uint64_t kBytesPerTexel = 3 + 4 + 1;  // colour, depth, validity
  const auto seen = std::count(result.snapshot.cell_seen.begin(), result.snapshot.cell_seen.end(), 1);
  std::size_t referenced = 0;
  const std::size_t cells = result.snapshot.surface->cells.cells.size();
  for (std::size_t cell = 0; cell < cells; ++cell) referenced += !result.snapshot.references.of_cell(cell).empty();
  return {{"views",
           {{"offered", result.planned.size()},
            {"kept", count(result.planned, Decision::kept)},
            {"replaced", count(result.planned, Decision::replaced)},
            {"rejected", count(result.planned, Decision::rejected)},
            {"outliers", count(result.planned, Decision::outlier)}}},
          {"refinement", refinement_summary(result, options.refine)},
          {"cells", cells},
          {"cells_seen", seen},
          {"cells_referenced", referenced},
          {"references", result.snapshot.references.views.size()},
          {"summed_coverage", result.summed_coverage},
          {"intrinsics", intrinsics_json(result)},
          {"texels", {{"resident", texels.resident}, {"budget", texels.largest * options.max_views}}},
          {"bytes", {{"resident", kBytesPerTexel * texels.resident}, {"peak_rss", peak_resident_bytes()}}},
          {"time_ms",
           {{"total", result.total_ms},
            {"per_view",
             {{"visibility", spread_of(result.planned, &Verdict::visibility_ms)},
              {"plan", spread_of(result.planned, &Verdict::plan_ms)},
              {"store", spread_of(result.planned, &Verdict::store_ms)},
              {"refine", spread_of(result.planned, &Verdict::refine_ms)}}}}}};
}

json effective_options(const BuildResult& result, const BuildOptions& options) {
  const CoverageOptions& coverage = result.effective.coverage;
  json hold_out = nullptr;
  if (options.hold_out) hold_out = {{"hold", options.hold_out->hold}, {"block", options.hold_out->block}};
  return {{"command", "build"},
          {"mesh", result.mesh_file.string()},
          {"hold_out", hold_out},
          {"views", options.max_views},
          {"references", coverage.max_references},
          {"partition", options.cells.partition == Partition::grid ? "grid" : "clusters"},
          {"cell_size", result.snapshot.surface->cells.size},
          {"normal_weight", options.cells.normal_weight},
          {"metric", coverage.metric == CoverageOptions::Metric::printed ? "printed" : "departures"},
          {"coverage_lambda", coverage.lambda},
          {"ideal_distance", coverage.ideal_distance},
          {"distance_sigma", coverage.distance_sigma > 0 ? coverage.distance_sigma : coverage.ideal_distance / 2},
          {"max_cell_coverage",
           coverage.max_cell_coverage > 0 ? coverage.max_cell_coverage : coverage.max_references / 2.0},
          {"min_view_gain", result.effective.min_view_gain},
          {"min_reference_gain", result.effective.min_reference_gain},
          {"victims", result.effective.victims},
          {"visibility", result.effective.visibility_px},
          {"visibility_by", options.visibility_by == VisibilityBy::gl ? "gl" : "rays"},
          {"refine_intrinsics", options.intrinsics == IntrinsicsUse::apply},
          {"depth_edge", result.effective.validity.depth_edge},
          {"edge_radius", result.effective.validity.edge_radius_px},
          {"fade", result.effective.validity.fade_px},
          {"refine", name_of(options.refine)},
          {"white_balance", result.effective.refinement.alignment.white_balance},
          {"masks", result.effective.refinement.trust.enabled}};
}

json plan_json(const BuildResult& result) {
  json views = json::array();
  for (const PlannedView& view : result.planned) {
    json entry = {{"name", view.name},
                  {"decision", name_of(view.verdict.decision)},
                  {"gain", view.verdict.gain},
                  {"cells_seen", view.verdict.cells_seen},
                  {"visibility_ms", view.verdict.visibility_ms},
                  {"plan_ms", view.verdict.plan_ms},
                  {"store_ms", view.verdict.store_ms}};
    if (view.verdict.refinement)
      entry["refinement"] = refinement_json(*view.verdict.refinement, view.verdict.refine_ms);
    if (view.verdict.replaced) entry["in_place_of"] = *view.verdict.replaced;
    views.push_back(std::move(entry));
  }
  return {{"views", std::move(views)}};
}

}  // namespace lumatlas
