// SPDX-License-Identifier: GPL-3.0-or-later
// The masks of captured photographs.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "tools/capture/sources/captured_photographs.h"

namespace lumatlas {

// Returns the folder, absolute and without links; empty where none is given. Throws InputError where there is no such
// folder.
[[nodiscard]] std::filesystem::path folder_of_masks(const std::optional<std::filesystem::path>& given);

// Returns the mask of each photograph that has one, by the photograph's name. Throws InputError where none has.
[[nodiscard]] std::map<std::string, std::filesystem::path> masks_by_photograph(const std::filesystem::path& folder,
                                                                               const CapturedPhotographs& captured);

// Returns name, size and time of each mask, by its photograph; null: there are none.
[[nodiscard]] nlohmann::json states_of_masks(const std::map<std::string, std::filesystem::path>& masks);

// Fills `folder` with links to the masks by the name that COLMAP knows, NAME.jpg.png, in the place of what is there.
// Returns the folder, or an empty path where there are no masks.
[[nodiscard]] std::filesystem::path link_masks_for_colmap(const std::map<std::string, std::filesystem::path>& masks,
                                                          const std::filesystem::path& folder);

}  // namespace lumatlas
