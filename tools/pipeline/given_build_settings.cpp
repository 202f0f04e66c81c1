// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/given_build_settings.h"

#include <algorithm>
#include <utility>

#include "tools/pipeline/build_settings.h"

namespace lumatlas {

GivenBuildSettings::GivenBuildSettings(std::vector<Assignment> given) : given_(std::move(given)) {
  const Settings<BuildOptions> table = build_settings();
  for (auto one = given_.begin(); one != given_.end(); ++one) {
    const Setting<BuildOptions>* const row = find_setting(table, one->name);
    if (row == nullptr) throw SettingError(no_such_setting(one->name, names_of(table)));
    const std::string complaint = row->rule.complaint(one->value);
    if (!complaint.empty()) throw SettingError(one->name + ": " + complaint);
    const bool is_second =
        std::any_of(given_.begin(), one, [&](const Assignment& other) { return other.name == one->name; });
    if (is_second) throw SettingError(one->name + ": is given twice");
  }
}

std::optional<std::string> GivenBuildSettings::value(std::string_view name) const {
  const auto one = std::find_if(given_.begin(), given_.end(), [&](const Assignment& a) { return a.name == name; });
  return one == given_.end() ? std::nullopt : std::optional(one->value);
}

void GivenBuildSettings::refuse(std::string_view name, const std::string& why) const {
  if (value(name)) throw SettingError(std::string(name) + ": " + why);
}

void GivenBuildSettings::refuse_subject(std::string_view subject, const std::string& why) const {
  for (const Assignment& one : given_) {
    if (one.name.starts_with(subject)) throw SettingError(one.name + ": " + why);
  }
}

void GivenBuildSettings::check_coverage(const CoverageOptions& coverage) const {
  if (coverage.metric != CoverageOptions::Metric::directions) return;
  refuse_subject("departures.", "needs coverage.metric=departures or coverage.metric=printed");
  if (!coverage.demand) return;
  refuse("coverage.ideal-distance",
         "needs coverage.demand=off, or coverage.metric=departures or coverage.metric=printed");
}

// Tiles, but not whole views, have the settings that this refuses.
void GivenBuildSettings::check_tiles() const {
  if (value("tiles.layout") != "layers") return;
  for (const char* const setting : {"tiles.tile", "tiles.gutter", "tiles.texels"}) {
    refuse(setting, "needs tiles.layout=tiles");
  }
}

// Tiles are compressed only where a budget asks for it, and their gutter allows it.
void GivenBuildSettings::set_texels(BuildOptions& options) const {
  TileOptions& tiles = options.tiles;
  const bool has_gutter = value("tiles.gutter").has_value();
  if (tiles.texels != TexelFormat::rgb8) {
    if (!has_gutter) tiles.gutter_px = kGutterOfBlocks;
    if (tiles.gutter_px < 2) refuse("tiles.gutter", "must be 2, 4 or 8 with tiles.texels=bc7");
    if (tiles.gutter_px == 8 && tiles.tile_px % 16 != 0) {
      refuse("tiles.tile", "must be a multiple of 16 with tiles.texels=bc7 and tiles.gutter=8");
    }
  }
  if (!options.tight_tiles) return;
  const bool is_fit_for_blocks = !has_gutter || tiles.gutter_px == 2 || tiles.gutter_px == 4;
  options.tight_tiles.reset();
  if (is_fit_for_blocks && !tiles.whole_views()) options.tight_tiles = compressed_tiles(tiles);
}

void GivenBuildSettings::apply(BuildOptions& options) const {
  assign_all(build_settings(), options, given_);
  check_coverage(options.planner.coverage);
  check_tiles();
  set_texels(options);
  if (options.order == StreamOrder::shuffled || options.choice == ViewChoice::random) return;
  refuse("stream.seed", "needs stream.order=shuffled or stream.choice=random");
}

void GivenBuildSettings::check_budget(const ModelBudget& budget, const BuildOptions& options) const {
  if (!options.tiles.whole_views() && (budget.gpu_bytes > 0 || budget.automatic)) return;
  refuse("budget.least-scale", "needs tiles.layout=tiles and a --budget of auto or in bytes");
}

void GivenBuildSettings::check_refinement(RefineMode refine) const {
  if (refine == RefineMode::none) refuse("alignment.white-balance", "needs --refine exposure, pose, all or joint");
  if (refine != RefineMode::all && refine != RefineMode::joint) {
    refuse("refinement.lenses", "needs --refine all or joint");
  }
  if (refine != RefineMode::joint) refuse("refinement.shutters", "needs --refine joint");
  if (refine != RefineMode::none && refine != RefineMode::exposure) return;
  for (const char* const setting : {"alignment.prior", "alignment.max-move"}) {
    refuse(setting, "needs --refine pose, all or joint");
  }
}

void GivenBuildSettings::choose_by_given(PlannerOptions& planner) const {
  const Settings<BuildOptions> table = build_settings();
  BuildOptions options;
  options.planner = planner;
  for (const char* const name :
       {"coverage.direction-weight", "coverage.direction-width", "coverage.references", "planner.min-gain"}) {
    if (const auto given = value(name)) assign(table, options, name, *given);
  }
  planner = options.planner;
}

}  // namespace lumatlas
