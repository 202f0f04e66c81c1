// SPDX-License-Identifier: GPL-3.0-or-later
// Measures how long the driver takes for each pass of a picture.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "blend/renderer.h"

namespace lumatlas {

// The time of one pass, milliseconds, medians over pictures. A pass that a picture has several times counts with their
// sum.
struct PassTime {
  std::string pass;
  double wall = 0, processor = 0;  // where the driver finishes each pass before the next one begins
  std::optional<double> gpu;       // by the GPU's own clock, without waiting; none where the driver has no such clock
};

// Draws each picture twice after one that sets up: once for the wall and the processor, once for the GPU's clock. The
// passes are in the order in which they are first drawn. Throws std::invalid_argument for no cameras.
[[nodiscard]] std::vector<PassTime> pass_times(Renderer& renderer, const std::vector<Camera>& cameras,
                                               const BlendOptions& blend);

}  // namespace lumatlas
