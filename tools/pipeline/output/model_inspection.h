// SPDX-License-Identifier: GPL-3.0-or-later
// The contents of a model, its sizes on disk and on the GPU, and the sizes that it was allowed.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace lumatlas {

// Returns whether a path is a model rather than a scene: a file, or a folder with the file of a model.
[[nodiscard]] bool is_model(const std::filesystem::path& path);

// Returns the JSON that `inspect --json` prints of a model:
//   mesh                 vertices (split at the borders of cells) and faces
//   cells, references    count, seen and per_cell: how many cells refer to 0, 1, 2 ... views
//   views                count and pixels of all
//   tiles                size and gutter in pixels, resident and of (all tiles of all views); null: whole views
//   texels, bytes        resident on the GPU with their levels and depth; format: of texels, rgb8 or bc7; budget: bytes
//                        that the model was built with, null: unbounded or not known
//   gpu                  where all bytes on the GPU go: see blend/gpu_bytes.h
//   parsimony            as in build_summary.h, of a model that was built with --budget auto; null: of any other
//   file                 bytes on disk: json, mesh, vertices, tables, photographs, masks, texture, and their sum
// Throws InputError like read_model(), except for faults in the images, whose pixels it does not read.
[[nodiscard]] nlohmann::json inspect_model(const std::filesystem::path& model);

// That "file" alone, and a line of it.
[[nodiscard]] nlohmann::json file_bytes_json(const std::filesystem::path& model);
[[nodiscard]] std::string file_bytes_text(const nlohmann::json& file);

// Returns the inspection as a few lines of text.
[[nodiscard]] std::string inspection_text(const nlohmann::json& model);

}  // namespace lumatlas
