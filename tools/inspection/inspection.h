// SPDX-License-Identifier: GPL-3.0-or-later
// What a scene holds and what is wrong with it.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "mesh/cells.h"

namespace lumatlas {

// {"mesh": {"file", "file_vertices", "file_faces", "colors", "repairs": {WHAT: count}, "split_faces", "vertices",
// "faces", "area", "diameter", "offset"}, "cells": {"count", "size", "partition", "area_share": {"p5", "median",
// "p95"}, "unseen"}, "views": {"form", "notes": [], "count", "lenses": {"MODEL WxH": count}, "median_distance",
// "covered", "blind": [names]}, "fit": mesh_diagnosis_json(), "warnings": []}. Looks at the mesh through every camera,
// at low resolution, and at some of the photographs. Throws InputError for a scene that cannot be used at all.
[[nodiscard]] nlohmann::json inspect_scene(const std::filesystem::path& scene,
                                           const std::optional<std::filesystem::path>& mesh_file,
                                           const CellOptions& options, bool quiet);

}  // namespace lumatlas
