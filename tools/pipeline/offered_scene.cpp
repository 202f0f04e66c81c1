// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/offered_scene.h"

#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "tools/settings/option_tables.h"

namespace lumatlas {

namespace {

// The notes of a build on refinement, without its masks.
Settings<RefinementOptions> refinement_table() {
  return joined<RefinementOptions>(
      {within<RefinementOptions>(
           "refinement.", refinement_settings(), [](auto& options) -> auto& { return options; }),
       within<RefinementOptions>("alignment.", alignment_settings(), &RefinementOptions::alignment)});
}

RefinementOptions refinement_of(const ModelNotes& notes, const std::filesystem::path& model) {
  RefinementOptions refinement;
  refinement.alignment.pose = refinement.alignment.exposure = false;
  if (!notes.options.is_object() || !notes.options.contains("refine")) return refinement;
  try {
    const nlohmann::json& built = notes.options;
    const auto mode = built.at("refine").get<std::string>();
    const bool all = mode == "all" || mode == "joint";
    refinement.alignment.pose = all || mode == "pose";
    refinement.alignment.exposure = all || mode == "exposure";
    assign_values(refinement_table(), refinement, built.at("settings"));
    refinement.alignment.white_balance = refinement.alignment.exposure && refinement.alignment.white_balance;
    check(refinement);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(model.string() + ": its notes on refinement cannot be read (" + error.what() +
                     "): build the model again");
  } catch (const std::invalid_argument& error) {
    throw InputError(model.string() + ": its notes on refinement have impossible values (" + error.what() +
                     "): build the model again");
  }
  return refinement;
}

}  // namespace

OfferedPhotographs offered_photographs(const SceneViews& scene, const std::optional<HoldOut>& protocol,
                                       const ValidityOptions& validity, const ModelNotes& notes,
                                       const std::filesystem::path& model) {
  const std::vector<std::size_t> ranks = split(scene, protocol).input;
  const auto views = std::make_shared<std::vector<SceneView>>();
  OfferedPhotographs offered;
  for (const std::size_t rank : ranks) {
    const SceneView& view = scene.views[rank];
    views->push_back(view);
    offered.list.push_back({view.name, view.camera});
  }
  offered.read = [views](std::size_t number) { return load_photograph((*views)[number]); };
  offered.validity = validity;
  offered.refinement = refinement_of(notes, model);
  return offered;
}

}  // namespace lumatlas
