// SPDX-License-Identifier: GPL-3.0-or-later
// Sentences for SceneViews::notes about files in a scene's folders that are not used.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/scene/scene.h"

namespace lumatlas {

// The names that the mask of a photograph may have in a folder of masks, the preferred first: COLMAP's NAME.jpg.png,
// NAME.png, Metashape's NAME_mask.png, RealityScan's NAME.mask.png and NAME.jpg.mask.png, and NAME.jpg_mask.png.
[[nodiscard]] std::vector<std::filesystem::path> mask_names(const std::string& photograph);

// "FOLDER: has a mask of none of the N photographs: that of A would be A.png or ..., but there is B".
[[nodiscard]] std::string no_mask_fits(const std::filesystem::path& folder, const std::vector<SceneView>& views);

// Says how many photographs have no mask where others have one, and which masks in the folder fit no photograph.
// Returns nothing if there is no folder.
void note_masks(const std::filesystem::path& folder, SceneViews& scene);

// Says how many pictures lie beside the photographs of the scene without a pose, unless there are no more than the
// `left_out` that other notes tell of; and how many files there are of forms that this program does not read.
void note_unposed(std::size_t left_out, SceneViews& scene);

}  // namespace lumatlas
