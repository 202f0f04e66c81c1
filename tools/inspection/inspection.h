// SPDX-License-Identifier: GPL-3.0-or-later
// Lists what a scene holds and what is wrong with it.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "mesh/cells/cells.h"
#include "mesh/mesh.h"
#include "tools/scene/mesh/mesh_frame.h"
#include "tools/scene/scene.h"

namespace lumatlas {

// Returns what photographs show past a mesh. Mesh and views have one frame.
using LookPast = std::function<nlohmann::json(const SceneViews& views, const Mesh& mesh, const glm::dvec3& offset)>;

// {"mesh": {"file", "file_vertices", "file_faces", "colors", "repairs": {WHAT: count}, "split_faces", "vertices",
// "faces", "area", "diameter", "offset"}, "cells": {"count", "size", "partition", "area_share": {"p5", "median",
// "p95"}, "unseen"}, "views": {"form", "notes": [], "count", "lenses": {"MODEL WxH": count}, "median_distance",
// "covered", "blind": [names]}, "fit": mesh_diagnosis_json(), "frames", "warnings": []}. Looks at the mesh through
// every camera, at low resolution, and at some of the photographs. "frames" is what `look_past` says of a mesh that
// fits, else null. Throws InputError for a scene that cannot be used at all.
[[nodiscard]] nlohmann::json inspect_scene(const std::filesystem::path& scene,
                                           const std::optional<std::filesystem::path>& mesh_file,
                                           const MeshFrame& mesh_frame, const CellOptions& options, bool quiet,
                                           const LookPast& look_past = {});

}  // namespace lumatlas
