// SPDX-License-Identifier: GPL-3.0-or-later
// Options that depend on the scene: "=diameter/60" for a cell's size, "=offered/4" for a number of views.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>

#include "tools/lab/sweep/sweep.h"

namespace lumatlas {

struct SceneFacts {
  double diameter = 0;          // of the mesh, scene units
  std::size_t photographs = 0;  // all of them
  std::size_t offered = 0;      // less those that are held out
  double texels = 0;            // of the offered photographs, or of the first --max-views of them
  double bytes = 0;             // on the GPU, of these in exact tiles with the whole mesh, without references
};

// Returns the facts of a scene under the options of `lumatlas build` (--hold, --block, --mesh, --max-views if it is a
// number). Throws InputError where the scene cannot be read.
[[nodiscard]] SceneFacts scene_facts(const std::filesystem::path& scene, const OptionValues& build);

// The options with every text that begins with '=' replaced: by `scene` and what follows for "=scene/REST", else by the
// quantity (diameter, photographs, offered, texels or bytes) divided by or times the number that follows. Photographs
// and bytes become whole numbers of at least 1, texels a size ("1200texels"). Asks for the facts only where it needs
// them. Throws InputError naming option, text and what there is.
[[nodiscard]] OptionValues resolved(OptionValues options, const std::filesystem::path& scene,
                                    const std::function<SceneFacts()>& facts);

}  // namespace lumatlas
