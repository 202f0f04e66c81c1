// SPDX-License-Identifier: GPL-3.0-or-later
// From the options and settings of `lumatlas build` to those of the library, with the rules between them.
#include <chrono>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/cli/flags/build_flags.h"
#include "tools/cli/flags/option_rules.h"
#include "tools/pipeline/build_settings.h"
#include "tools/pipeline/given_build_settings.h"
#include "tools/pipeline/model_budget.h"
#include "tools/pipeline/output/model_output.h"
#include "tools/pipeline/surface/baked_texture.h"
#include "tools/stereo/scene_stereo.h"

namespace lumatlas {

namespace {

// The measure with its thresholds, and the masks, as printed; the surface as it is given; and views refined while they
// come, as in section 3.3, their lenses as given, unless --refine says otherwise: poses that are exact need none.
std::vector<Assignment> settings_of_paper(const BuildFlags& flags) {
  std::vector<Assignment> settings{
      {"coverage.metric", "printed"}, {"masks.edges", "both"}, {"surface.far-sphere", "off"}, {"surface.exact", "on"}};
  if (flags.refine->count() == 0) settings.push_back({"refinement.lenses", "off"});
  return settings;
}

void follow_paper(const BuildFlags& flags, BuildOptions& options) {
  BuildOptions printed = flags.settings.defaults();
  assign_all(build_settings(), printed, settings_of_paper(flags));
  flags.settings.agree_with_paper(printed);
  assign_all(build_settings(), options, settings_of_paper(flags));
  if (flags.refine->count() == 0) options.refine = RefineMode::all;
}

void check_tiles_are_used(const BuildFlags& flags) {
  if (flags.settings.given().value("tiles.layout") != "layers" || flags.photograph_bytes->count() == 0) return;
  throw CLI::ValidationError("--photograph-bytes", "needs tiles.layout=tiles");
}

ModelBudget budget_of(const BuildFlags& flags) {
  ModelBudget budget;
  budget.loss_db = flags.loss_db;
  if (flags.budget->count() == 0) return budget;
  budget.automatic = flags.budget_size == kAuto;
  if (budget.automatic) return budget;
  const SizeBound bound = size_bound(flags.budget_size);
  budget.gpu_bytes = bound.bytes;
  budget.texels = bound.texels;
  return budget;
}

// A model that is bounded by a loss is chosen by a measure of its own, from which settings that were given depart.
void choose_by_given(const GivenBuildSettings& given, BuildOptions& options) {
  if (options.planner.coverage.metric != CoverageOptions::Metric::directions) {
    throw CLI::ValidationError("--budget auto", "needs coverage.metric=directions");
  }
  given.choose_by_given(options.planner);
  if (options.choice != ViewChoice::online) {
    throw CLI::ValidationError("--budget auto", "needs stream.choice=online");
  }
}

// With tiles, a budget in bytes bounds all that the model takes on the GPU, one in texels the texture array; the
// photographs that they are cut from are bounded by their number, or by bytes of their own.
void set_budget(const BuildFlags& flags, const GivenBuildSettings& given, BuildOptions& options) {
  const ModelBudget budget = budget_of(flags);
  given.check_budget(budget, options);
  if (flags.loss->count() > 0 && !budget.automatic) throw CLI::ValidationError("--loss", "needs --budget auto");
  try {
    apply_budget(budget, flags.max_views->count() > 0, options);
  } catch (const std::invalid_argument& error) {
    throw CLI::ValidationError(error.what());
  }
  if (budget.automatic) choose_by_given(given, options);
}

// A model whose mesh counts is to have few faces, unless the user wants all of them. With --watch the mesh is there
// before most cameras are known, by which pictures are judged.
FaceOptions faces_of(const BuildFlags& flags, const TileOptions& tiles) {
  const bool few = !flags.watch && wants_few_faces(budget_of(flags), tiles);
  FaceOptions faces;
  if (flags.faces == kAuto || (flags.faces.empty() && few)) {
    faces.pixels = kFacesPixels;
  } else if (!flags.faces.empty() && flags.faces != kKeep) {
    faces.faces = std::stoull(flags.faces);
  }
  return faces;
}

std::optional<std::uint32_t> texture_of(const std::string& text) {
  if (text == kNoTexture) return std::nullopt;
  const std::uint64_t side_px = std::stoull(text);
  if (side_px < kLeastTexturePx || side_px > kMostTexturePx) {
    throw CLI::ValidationError("--texture", "must be " + std::to_string(kLeastTexturePx) + " to " +
                                                std::to_string(kMostTexturePx) + ", or " + kNoTexture);
  }
  return static_cast<std::uint32_t>(side_px);
}

void watch_scene(const BuildFlags& flags, BuildOptions& options) {
  const auto refuse = [](const char* option, const char* why) { throw CLI::ValidationError(option, why); };
  if (options.hold_out) refuse("--hold", "needs the names of all photographs, which --watch does not know yet");
  if (options.choice != ViewChoice::online) {
    refuse("--set stream.choice", "must be online with --watch, which cannot look ahead");
  }
  if (options.order != StreamOrder::given) {
    refuse("--set stream.order", "must be given with --watch, which offers photographs as they arrive");
  }
  if (!options.max_views && options.planner.max_bytes + options.bound.gpu_bytes() == 0) {
    refuse("--budget auto",
           "needs --max-views or --photograph-bytes with --watch, because the number of photographs is not known "
           "beforehand");
  }
  options.pictures.skip_bad = true;  // for validate, which reads this scene again
  WatchOptions& watch = options.watch.emplace();
  watch.end = [] { return false; };
  if (flags.idle_s > 0) watch.idle = std::chrono::seconds(flags.idle_s);
  watch.warn = [](const std::string& sentence) { std::cerr << "warning: " << sentence << '\n'; };
}

// With --quiet the address is a result: see ShownBuild.
void require_address_known(const BuildFlags& flags) {
  if (!flags.view || !flags.quiet || !flags.json_output || flags.server.port != 0) return;
  throw CLI::ValidationError("--view", "needs --port with --quiet and --json, for nothing else would say its address");
}

void set_inputs(const BuildFlags& flags, BuildOptions& options) {
  if (!flags.mesh.empty()) options.mesh = flags.mesh;
  options.mesh_frame = flags.mesh_frame.frame();
  options.georeference = flags.georeference.reference();
  options.pictures = flags.pictures.folders();
  options.pictures.skip_bad = flags.skip_bad;
  options.hold_out = flags.hold.protocol();
  options.completion.surface = !flags.mesh_as_given && !flags.paper;
  options.completion.stereo_folder = stereo_folder_of(flags.output);
  options.memory.scratch_folder = scratch_folder_for(flags.output);
}

}  // namespace

BuildOptions build_options_of(const BuildFlags& flags) try {
  const GivenBuildSettings given(flags.settings.given().all());
  BuildOptions options = flags.options;
  if (flags.paper) follow_paper(flags, options);
  given.apply(options);
  set_inputs(flags, options);
  check_tiles_are_used(flags);
  options.faces = faces_of(flags, options.tiles);
  options.texture_px = texture_of(flags.texture);
  set_budget(flags, given, options);
  given.check_refinement(options.refine);
  if (flags.watch) watch_scene(flags, options);
  require_address_known(flags);
  check_usage(options);
  return options;
} catch (const SettingError& error) {
  throw CLI::ValidationError(std::string("--set ") + error.what());
}

}  // namespace lumatlas
