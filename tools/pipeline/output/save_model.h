// SPDX-License-Identifier: GPL-3.0-or-later
// A model that was built, onto disk, with what tells how it was built.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "atlas/images/photograph.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/output/model_output.h"

namespace lumatlas {

// Writes the model, the options in effect and what became of each photograph: into a folder (a tileset, images/,
// lumatlas.json, plan.json), or into one file if `path` ends in .glb. An earlier model there is replaced; the new one
// appears complete or not at all. Returns the summary (tools/pipeline/output/build_summary.h) that it wrote. Throws
// InputError where something else stands at `path`, where the file system refuses, and for a model that is not worth
// its place (tools/pipeline/output/worth_saving.h); Interrupted.
nlohmann::json save_model(const BuildResult& result, const std::filesystem::path& path,
                          const ImageCoding& photographs = {});

// Saves into an output that the caller opened before the build, so that an unwritable path is refused at once.
// `unplaced`: see require_worth_saving().
nlohmann::json save_model(const BuildResult& result, ModelOutput& output, const ImageCoding& photographs = {},
                          std::size_t unplaced = 0);

}  // namespace lumatlas
