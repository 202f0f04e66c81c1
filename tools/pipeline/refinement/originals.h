// SPDX-License-Identifier: GPL-3.0-or-later
// The files of photographs that were stored, which are read again to be corrected.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/pipeline/build_options.h"
#include "tools/scene/scene.h"

namespace lumatlas {

// Called with a sentence.
using WarnOfOriginals = std::function<void(const std::string& warning)>;

// Returns the warning for a watched scene, whose build goes on without files that are gone. Empty for other scenes.
[[nodiscard]] WarnOfOriginals warning_of_originals(const BuildOptions& options);

// Returns the view of that name, which must be among the views.
[[nodiscard]] SceneView& view_named(std::vector<SceneView>& views, const std::string& name);

// Throws InputError unless the view's photograph and mask can be opened and have the size that they had.
void require_original(const SceneView& view);

}  // namespace lumatlas
