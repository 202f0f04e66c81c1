// SPDX-License-Identifier: GPL-3.0-or-later
// The photographs of the scene that a model was built from, for a texture from all of them.
#pragma once

#include <filesystem>
#include <optional>

#include "atlas/views/validity.h"
#include "tools/pipeline/output/model_output.h"
#include "tools/scene/scene.h"
#include "tools/texture/placed_photographs.h"

namespace lumatlas {

// Returns the photographs that `protocol` lets a model learn from (none: all), without bad ones. Exposures, poses and
// outliers are found as the model's notes say that it was built; nothing is refined where they say nothing. Throws
// InputError, naming `model`, if the notes have impossible values.
[[nodiscard]] OfferedPhotographs offered_photographs(const SceneViews& scene, const std::optional<HoldOut>& protocol,
                                                     const ValidityOptions& validity, const ModelNotes& notes,
                                                     const std::filesystem::path& model);

}  // namespace lumatlas
