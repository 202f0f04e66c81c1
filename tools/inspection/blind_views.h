// SPDX-License-Identifier: GPL-3.0-or-later
// Whether the views of a scene see its mesh, looked at before anything is planned.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "mesh/visibility.h"
#include "tools/scene/scene.h"

namespace lumatlas {

// Views that see next to nothing of the mesh.
struct BlindViews {
  std::size_t looks = 0, blind = 0;
  std::string first;  // by name
};

// Of the views of these ranks; of many some are looked through, evenly.
[[nodiscard]] BlindViews blind_views(const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks,
                                     const Visibility& visibility);

// Throws InputError, naming the mesh, if more than three quarters of the views that were looked through are blind: a
// mesh in other coordinates, or of another scene, is seen by chance. `likely` says what is likely to be wrong, see
// MeshDiagnosis; empty: not known.
void require_seen(const std::filesystem::path& mesh_file, const BlindViews& views, const std::string& likely);

}  // namespace lumatlas
