// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps the corrections of a build, of lenses and of motions while a shutter read, in the model's notes, so that
// photographs of the scene can be corrected as those in the model are.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/pipeline/build_model.h"
#include "tools/pipeline/output/model_output.h"
#include "tools/scene/scene.h"

namespace lumatlas {

// A list, one entry a lens.
[[nodiscard]] nlohmann::json lenses_json(std::span<const RefinedLens> lenses);

// One line a lens whose photographs were undistorted again: "lens: k1 -0.037, a corner moves 13.1 px; ...", and one a
// lens whose estimate moves a corner by half a pixel or more and was not applied.
[[nodiscard]] std::string lenses_text(std::span<const RefinedLens> lenses);

// "shutters": null where they were not refined.
[[nodiscard]] nlohmann::json shutters_json(const std::optional<RefinedShutters>& shutters);

// One line, or none where the photographs were left as they are.
[[nodiscard]] std::string shutters_text(const std::optional<RefinedShutters>& shutters);

// Takes black rims out of all photographs that are read from now on.
void leave_out_black_rims(std::vector<SceneView>& views);

// Gives the views the corrections of their lenses that were applied.
void correct_lenses(std::vector<SceneView>& views, std::span<const RefinedLens> lenses);

// The same from the notes of a saved model; nothing if they are null or name no lens. Where the build found black
// borders, they are left out of these views too (SceneView::black_rim). Throws InputError, naming `model`, if what
// stands there is no correction.
void correct_lenses(std::vector<SceneView>& views, const ModelNotes& notes, const std::filesystem::path& model);

// The same, and gives the views of the scene that the model was built of the motions of those that are stored there.
void correct_photographs(std::vector<SceneView>& views, const ModelNotes& notes, const std::filesystem::path& model);

}  // namespace lumatlas
