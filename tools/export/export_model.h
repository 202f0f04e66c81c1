// SPDX-License-Identifier: GPL-3.0-or-later
// A model as a page for browsers, or as a plain textured mesh for other programs.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "atlas/model/model_file.h"
#include "tools/base/progress.h"
#include "tools/export/export_options.h"

namespace lumatlas {

// Writes the export to `output`, where an earlier one is replaced; the new one appears complete or not at all. `file`:
// where the model was read from. Returns what `lumatlas export --json` prints, whose keys tools/cli/README.md lists.
// Throws what check() throws, InputError, and what `progress` throws.
nlohmann::json export_model(const Model& model, const std::filesystem::path& file, const std::filesystem::path& output,
                            const ExportOptions& options, const StageProgress& progress);

}  // namespace lumatlas
