// SPDX-License-Identifier: GPL-3.0-or-later
// The JSON that `lumatlas mesh --json` prints of a mesh.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "tools/meshing/scene_mesh.h"

namespace lumatlas {

// Returns an object; tools/cli/README.md lists its keys. `output`: the file that the mesh was written to. `time_ms`:
// wall time of the whole work.
[[nodiscard]] nlohmann::json mesh_json(const SceneMesh& made, const std::filesystem::path& output, double time_ms);

}  // namespace lumatlas
