// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/output/build_summary.h"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "mesh/base/median.h"
#include "mesh/base/number_text.h"
#include "tools/budget/gpu_budget.h"
#include "tools/pipeline/build_settings.h"
#include "tools/pipeline/refinement/lens_notes.h"
#include "tools/pipeline/refinement/refinement_json.h"

namespace lumatlas {

namespace {

using nlohmann::json;

// Returns the spread of the values above 0, because a stage that was not done took no time.
json spread_of_times(std::vector<double> values) {
  std::erase(values, 0.0);
  if (values.empty()) return {{"median", 0}, {"p95", 0}, {"views", 0}};
  return {{"median", percentile(values, 0.5)}, {"p95", percentile(values, 0.95)}, {"views", values.size()}};
}

template <typename Time>
json spread_of(const std::vector<PlannedView>& planned, const Time& time) {
  std::vector<double> values;
  values.reserve(planned.size());
  for (const PlannedView& view : planned) values.push_back(time(view));
  return spread_of_times(std::move(values));
}

json times_per_view(const std::vector<PlannedView>& planned) {
  return {{"visibility", spread_of(planned, [](const PlannedView& view) { return view.verdict.visibility_ms; })},
          {"plan", spread_of(planned, [](const PlannedView& view) { return view.verdict.plan_ms; })},
          {"read", spread_of(planned, [](const PlannedView& view) { return view.read_ms; })},
          {"refine", spread_of(planned, [](const PlannedView& view) { return view.verdict.refine_ms; })},
          {"store", spread_of(planned, [](const PlannedView& view) { return view.verdict.store_ms; })}};
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

std::uint64_t bytes_per_texel() {
  Camera one;
  one.width = one.height = 1;
  return stored_bytes(one);
}

// The size of the stored views, and its bounds.
struct Holding {
  std::size_t views = 0;
  std::uint64_t texels = 0;                    // resident, those of gutters included
  std::optional<std::uint64_t> texels_budget;  // none: unbounded
  std::uint64_t bytes = 0;
  std::optional<std::uint64_t> bytes_budget;
};

// Counts whole views; a bound by count allows that many of the largest.
void hold_layers(const BuildResult& result, const BuildOptions& options, Holding& holding) {
  std::uint64_t largest = 0;
  for (const auto& view : result.snapshot.views) {
    if (!view) continue;
    const std::uint64_t pixels = std::uint64_t{view->camera.width} * view->camera.height;
    holding.texels += pixels;
    largest = std::max(largest, pixels);
  }
  holding.bytes = result.stored_bytes;
  if (options.max_views) holding.texels_budget = largest * *options.max_views;
  if (const std::uint64_t bytes = options.planner.max_bytes; bytes > 0) {
    holding.texels_budget = std::min(holding.texels_budget.value_or(bytes), bytes / bytes_per_texel());
  }
  if (holding.texels_budget) holding.bytes_budget = *holding.texels_budget * bytes_per_texel();
}

void hold_tiles(const BuildResult& result, const BuildOptions& options, Holding& holding) {
  const TileTable& tiles = result.snapshot.tiles;
  const std::uint64_t place_texels = std::uint64_t{options.tiles.place_px()} * options.tiles.place_px();
  holding.texels = place_texels * tiles.resident_tiles();
  holding.bytes = place_bytes(options.tiles) * tiles.resident_tiles();
  if (options.bound.bytes() == 0) return;
  if (tiles.options.max_tiles > 0) holding.texels_budget = place_texels * tiles.options.max_tiles;
  holding.bytes_budget = options.bound.bytes();
}

Holding holding_of(const BuildResult& result, const BuildOptions& options) {
  Holding holding;
  holding.views = static_cast<std::size_t>(std::count_if(result.snapshot.views.begin(), result.snapshot.views.end(),
                                                         [](const auto& view) { return view != nullptr; }));
  options.tiles.whole_views() ? hold_layers(result, options, holding) : hold_tiles(result, options, holding);
  return holding;
}

json or_null(const std::optional<std::uint64_t>& value) {
  return value ? json(*value) : json();
}

json bytes_json(const BuildResult& result, const Holding& holding) {
  return {{"resident", holding.bytes},
          {"budget", or_null(holding.bytes_budget)},
          {"photographs", result.stored_bytes},
          {"scratch", result.scratch_bytes},
          {"peak_rss", peak_resident_bytes()}};
}

json offline_json(const BuildResult& result) {
  if (!result.offline) return nullptr;
  const OfflineChoice& choice = result.offline->choice;
  return {{"summed_coverage", choice.summed_coverage}, {"greedy_coverage", choice.greedy_coverage},
          {"evaluations", choice.evaluations},         {"exchanges", choice.exchanges},
          {"look_ms", result.offline->look_ms},        {"choose_ms", result.offline->choose_ms}};
}

json parsimony_json(const BuildResult& result, const Holding& holding) {
  if (!result.parsimony) return nullptr;
  const Parsimony& p = *result.parsimony;
  const auto against = [](std::uint64_t stored, std::uint64_t unbounded) -> json {
    return {{"stored", stored}, {"unbounded", unbounded}};
  };
  return {{"bound_db", *result.effective.max_loss_db + result.options.bound.texel_loss_db()},
          {"predicted_loss_db", p.loss_db},
          {"measured_loss_db", p.measured ? json(p.measured->mean_db) : json()},
          {"measured_loss_error_db", p.measured ? json(p.measured->error_db) : json()},
          {"texel_loss_db", result.texel_loss_db},
          {"face_loss_db", result.face_loss_db},
          {"gap", p.predicted.gap},
          {"reference_gap", p.predicted.reference_gap},
          {"references_given_up", p.predicted.references_given_up},
          {"short_of_room", p.predicted.short_of_room},
          {"taken_away", p.taken_away},
          {"views", against(holding.views, p.views)},
          {"references", against(result.snapshot.references.views.size(), p.references)},
          {"gpu_bytes", {{"stored", result.gpu_bytes.sum()}, {"before", p.gpu_bytes}}}};
}

// Null: other programs show vertex colours.
json texture_json(const std::optional<BakedTexture>& baked) {
  if (!baked) return nullptr;
  return {{"side", baked->texture.image.width},
          {"charts", baked->charts},
          {"per_pixel", baked->texels_per_pixel},
          {"ms", baked->bake_ms}};
}

std::string printed(const char* format, double value) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

std::string megabytes(const json& bytes) {
  return printed("%.1f", bytes.get<double>() / 1e6);
}

json frames_json(const std::optional<FrameShares>& frames) {
  if (!frames) return nullptr;
  return {{"surface", frames->surface},
          {"added", frames->added},
          {"far", frames->far},
          {"filled", std::max(0.0, 1 - frames->surface - frames->added - frames->far)}};
}

json trust_json(const std::optional<TrustShares>& trust) {
  if (!trust) return nullptr;
  return {{"within_1_px", trust->within_1_px},
          {"within_2_px", trust->within_2_px},
          {"within_4_px", trust->within_4_px},
          {"measured", trust->measured}};
}

std::string views_line(const json& s) {
  const json& views = s["views"];
  const json& bytes = s["bytes"];
  std::string line = views["stored"].dump() + " of " + views["offered"].dump() + " views stored (" +
                     views["replaced"].dump() + " took another's place, " + views["rejected"].dump() + " rejected, " +
                     views["outliers"].dump() + " outliers)\n  on the GPU " + gpu_bytes_text(s["gpu"]);
  if (const double scale = s["texels"]["scale"].get<double>(); scale < 1) {
    line += "; photographs at " + printed("%.0f", 100 * scale) + " % of their sides";
  }
  if (bytes["budget"].is_null()) return line;
  // Budgets of texels and numbers of views bound the photographs alone.
  if (s["gpu"]["sum"] <= bytes["budget"]) {
    line += "; budget " + megabytes(bytes["budget"]) + " MB";
    const json& loss = s["texels"].value("loss_db", json());
    return loss.is_null() ? line : line + ", by which photographs lose " + printed("%.2f", loss.get<double>()) + " dB";
  }
  return line + "; photographs " + megabytes(bytes["resident"]) + " MB of " + megabytes(bytes["budget"]);
}

// Returns the line on faces that were removed for a budget; empty if there were none.
std::string faces_line(const json& s) {
  const json& faces = s["faces"];
  if (faces["taken_away"] == 0) return "";
  return faces["kept"].dump() + " faces, " + faces["taken_away"].dump() + " removed, which moved the surface by " +
         printed("%.2g", faces["moved"].get<double>()) + "\n  ";
}

// Returns the line on faces that were removed; empty if none was.
std::string contradicted_line(const json& s) {
  const json& faces = s["faces"];
  if (faces["contradicted"] == 0) return "";
  return faces["contradicted"].dump() + " faces in " + faces["contradicted_groups"].dump() + " groups, " +
         percent_text(faces["contradicted_pixels"].get<double>()) +
         " of what the matched photographs show of the mesh, were removed because photographs see through them\n  ";
}

// Empty where the mesh fills nearly all of the frames.
std::string frames_line(const json& s) {
  constexpr double kNearlyAll = 0.995;
  if (s["frames"].is_null() || s["frames"]["surface"] >= kNearlyAll) return "";
  const json& added = s["faces"]["added"];
  return frames_text(s["frames"]) + (added == 0 ? "" : "; " + added.dump() + " faces were added") + "\n  ";
}

// Returns the line on trust; empty where the deviation was not measured.
std::string trust_line(const json& s) {
  return s["trust"].is_null() ? "" : trust_text(s["trust"]) + "\n  ";
}

std::string cells_line(const json& s) {
  return s["cells"].dump() + " cells: " + s["cells_referenced"].dump() + " referenced, " +
         s["cells_not_referenced"].dump() + " seen but not referenced, " + s["cells_never_seen"].dump() +
         " never seen; " + s["references"].dump() + " references, " + s["cells_full"].dump() +
         " cells full; coverage " + printed("%.4g", s["summed_coverage"].get<double>());
}

std::string times_line(const json& s) {
  std::string line = "ms a view, median / p95:";
  const char* separator = " ";
  for (const char* const stage : {"visibility", "plan", "read", "refine", "store"}) {
    const json& time = s["time_ms"]["per_view"][stage];
    if (time["views"] == 0) continue;
    line += separator + std::string(stage) + printed(" %.1f", time["median"].get<double>()) +
            printed(" / %.1f", time["p95"].get<double>());
    separator = ", ";
  }
  return line + printed("; %.0f s in all", s["time_ms"]["total"].get<double>() / 1000);
}

// The settings in effect, with the values that stand for automatic ones.
json settings_in_effect(const BuildResult& result, const BuildOptions& options) {
  BuildOptions used = options;
  used.planner = result.effective;
  CoverageOptions& coverage = used.planner.coverage;
  if (coverage.distance_sigma == 0) coverage.distance_sigma = coverage.ideal_distance / 2;
  if (coverage.max_cell_coverage == 0) coverage.max_cell_coverage = coverage.max_references / 2.0;
  used.completion.far_sphere = used.completion.far_sphere && !used.watch;
  used.tight_tiles.reset();
  return values_of(build_settings(), used);
}

json budget_of(const BuildOptions& options) {
  const std::uint64_t bytes = options.tiles.whole_views() ? options.planner.max_bytes : options.bound.bytes();
  return bytes > 0 ? json(bytes) : json();
}

json skipped_names(const BuildResult& result) {
  json names = json::array();
  for (const SkippedView& view : result.skipped) names.push_back(view.name);
  return names;
}

bool is_measured(const json& p) {
  return p.contains("measured_loss_db") && p["measured_loss_db"].is_number();
}

// Names the part of the loss that was measured, if any. If measuring broke off, only that of texels and faces is known.
std::string measured_text(const json& p) {
  const double by_texels = p.value("texel_loss_db", 0.0), with_faces = p.value("face_loss_db", 0.0);
  std::vector<std::string> parts;
  if (is_measured(p)) parts.push_back(printed("%.3f", p["measured_loss_db"].get<double>()) + " measured");
  if (by_texels != 0) parts.push_back(printed("%.3f", by_texels) + " by coarser texels");
  if (with_faces != 0) parts.push_back(printed("%.3f", with_faces) + " with fewer faces too");
  if (parts.empty()) return "";
  std::string text = " (" + parts.front();
  for (std::size_t i = 1; i < parts.size(); ++i) text += ", " + parts[i];
  return text + ")";
}

}  // namespace

std::vector<std::size_t> cells_by_references(const ReferenceTable& references) {
  std::vector<std::size_t> histogram(1, 0);
  for (std::size_t cell = 0; cell + 1 < references.offsets.size(); ++cell) {
    const std::size_t count = references.of_cell(cell).size();
    if (count >= histogram.size()) histogram.resize(count + 1, 0);
    ++histogram[count];
  }
  return histogram;
}

std::string parsimony_text(const json& p) {
  const auto against = [&](const char* what) {
    return p[what]["stored"].dump() + " of " + p[what]["unbounded"].dump() + " " + what;
  };
  std::string text =
      "predicted loss " + printed("%.3f", p["predicted_loss_db"].get<double>()) + " dB" + measured_text(p) +
      " of at most " + printed("%.3g", p["bound_db"].get<double>()) + " against all views: " + against("views") + ", " +
      against("references") +
      (p.value("references_given_up", 0) > 0 ? " (" + p["references_given_up"].dump() + " of stored views given up)"
                                             : "") +
      (p.contains("gpu_bytes")
           ? ", " + megabytes(p["gpu_bytes"]["stored"]) + " of " + megabytes(p["gpu_bytes"]["before"]) + " MB"
           : "");
  if (p["predicted_loss_db"] <= p["bound_db"]) return text;
  if (p["short_of_room"].get<bool>()) {
    return text + "; more views were needed than --max-views or --photograph-bytes allow";
  }
  return is_measured(p) ? text : text + "; the demand changed after views were rejected";
}

std::string frames_text(const json& frames) {
  const auto percent = [&](const char* name) { return percent_text(frames[name].get<double>()); };
  return "pixels of the photographs: " + percent("surface") + " show the mesh, " + percent("added") +
         " added surface, " + percent("far") + " the far sphere; " + percent("filled") +
         " are filled from their surroundings";
}

std::string trust_text(const json& trust) {
  const auto percent = [&](const char* name) { return percent_text(trust[name].get<double>()); };
  return "error of the surface, seen " + number_text(kTrustAngle) + " degrees from a photograph: at most 1 pixel for " +
         percent("within_1_px") + " of the pixels, 2 for " + percent("within_2_px") + ", 4 for " +
         percent("within_4_px") + " (measured on " + percent("measured") + ")";
}

json summary(const BuildResult& result, const BuildOptions& options) {
  const Holding holding = holding_of(result, options);
  const std::size_t cells = result.snapshot.surface->cells.cells.size();
  const auto seen =
      static_cast<std::size_t>(std::count(result.snapshot.cell_seen.begin(), result.snapshot.cell_seen.end(), 1));
  const std::vector<std::size_t> by_references = cells_by_references(result.snapshot.references);
  const std::size_t referenced = cells - by_references.front();
  const std::uint32_t full = result.effective.coverage.max_references;
  return {{"fit", result.fit ? mesh_diagnosis_json(*result.fit) : json()},
          {"views",
           {{"offered", result.planned.size()},
            {"stored", holding.views},
            {"kept", count(result.planned, Decision::kept)},
            {"skipped", skipped_names(result)},
            {"replaced", count(result.planned, Decision::replaced)},
            {"rejected", count(result.planned, Decision::rejected)},
            {"outliers", count(result.planned, Decision::outlier)}}},
          {"refinement", refinement_summary(result, options.refine)},
          {"faces",
           {{"kept", result.snapshot.surface->near_faces()},
            {"added", result.added_faces},
            {"before", result.faces_before},
            {"contradicted", result.removed.faces},
            {"contradicted_groups", result.removed.groups},
            {"contradicted_pixels", result.removed.pixels},
            {"far", result.snapshot.surface->far_faces},
            {"taken_away", result.simplified_faces},
            {"moved", result.simplified_distance}}},
          {"frames", frames_json(result.frames)},
          {"trust", trust_json(result.trust)},
          {"closed_holes", result.closed_holes},
          {"cells", cells},
          {"cells_seen", seen},
          {"cells_referenced", referenced},
          {"cells_not_referenced", seen - referenced},
          {"cells_never_seen", cells - seen},
          {"cells_full", full < by_references.size() ? by_references[full] : 0},
          {"references", result.snapshot.references.views.size()},
          {"references_per_cell", by_references},
          {"summed_coverage", result.summed_coverage},
          {"offline", offline_json(result)},
          {"parsimony", parsimony_json(result, holding)},
          {"lenses", lenses_json(result.lenses)},
          {"shutters", shutters_json(result.shutters)},
          {"texels",
           {{"resident", holding.texels},
            {"budget", or_null(holding.texels_budget)},
            {"format", name_of(options.tiles.texels)},
            {"scale", result.scale},
            {"loss_db", result.fitted_loss ? json(result.fitted_loss->mean_db) : json()},
            {"loss_error_db", result.fitted_loss ? json(result.fitted_loss->error_db) : json()}}},
          {"bytes", bytes_json(result, holding)},
          {"gpu", gpu_bytes_json(result.gpu_bytes)},
          {"texture", texture_json(result.texture)},
          {"time_ms", {{"total", result.total_ms}, {"per_view", times_per_view(result.planned)}}}};
}

std::string summary_text(const json& s, const std::string& name) {
  const std::string parsimony = s["parsimony"].is_null() ? "" : parsimony_text(s["parsimony"]) + "\n  ";
  return name + ": " + views_line(s) + "\n  " + parsimony + frames_line(s) + contradicted_line(s) + trust_line(s) +
         faces_line(s) + cells_line(s) + "\n  " + times_line(s) + "\n";
}

json effective_options(const BuildResult& result, const BuildOptions& options) {
  const PlannerOptions& planner = result.effective;
  json hold_out = nullptr;
  if (options.hold_out) hold_out = {{"hold", options.hold_out->hold}, {"block", options.hold_out->block}};
  json all = {{"command", "build"},
              {"mesh", result.mesh_file.string()},
              {"close_holes", options.close_holes},
              {"mesh_as_given", !options.completion.surface || options.watch},
              {"hold_out", hold_out},
              {"skip_bad", options.pictures.skip_bad},
              {"watch", options.watch.has_value()},
              {"max_views", options.max_views ? json(*options.max_views) : json()},
              {"texture", options.texture_px ? json(*options.texture_px) : json()},
              {"budget", budget_of(options)},
              {"loss", planner.max_loss_db ? json(*planner.max_loss_db + options.bound.texel_loss_db()) : json()},
              {"photograph_bytes", planner.max_bytes > 0 ? json(planner.max_bytes) : json()},
              {"cell_size", result.snapshot.surface->cells.size},
              {"faces", options.faces.faces ? json(*options.faces.faces) : json()},
              {"faces_pixels", options.faces.pixels},
              {"visibility_by", options.visibility_by == VisibilityBy::gl ? "gl" : "rays"},
              {"refine", name_of(options.refine)},
              {"settings", settings_in_effect(result, options)}};
  all.update(mesh_frame_json(options.mesh_frame.value_or(MeshFrame{})));
  return all;
}

json plan_json(const BuildResult& result) {
  json views = json::array();
  for (const PlannedView& view : result.planned) {
    json entry = {{"name", view.name},
                  {"decision", name_of(view.verdict.decision)},
                  {"gain", view.verdict.gain},
                  {"cells_seen", view.verdict.cells_seen},
                  {"summed_coverage", view.summed_coverage},
                  {"visibility_ms", view.verdict.visibility_ms},
                  {"plan_ms", view.verdict.plan_ms},
                  {"read_ms", view.read_ms},
                  {"store_ms", view.verdict.store_ms}};
    if (view.verdict.refinement)
      entry["refinement"] = refinement_json(*view.verdict.refinement, view.verdict.refine_ms);
    if (!view.verdict.replaced.empty()) entry["in_place_of"] = view.verdict.replaced;
    views.push_back(std::move(entry));
  }
  return {{"views", std::move(views)}};
}

}  // namespace lumatlas
