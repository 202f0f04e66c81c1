// SPDX-License-Identifier: GPL-3.0-or-later
// The stages of making a mesh, as bars on stderr.
#pragma once

#include <memory>
#include <string>

#include "tools/base/progress.h"
#include "tools/meshing/scene_mesh.h"

namespace lumatlas {

// Its ticks throw Interrupted once the user has asked the program to stop.
inline StageProgress bars_on_standard_error(bool quiet) {
  return [quiet](const std::string& stage, std::size_t steps) {
    const auto bar = std::make_shared<Progress>(stage, steps, ProgressOptions::standard_error(quiet));
    return [bar](std::size_t done) { bar->tick(done); };
  };
}

}  // namespace lumatlas
