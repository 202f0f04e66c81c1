// SPDX-License-Identifier: GPL-3.0-or-later
// Measures how long the renderer takes for a picture, from places between those of the photographs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "atlas/atlas.h"
#include "blend/renderer.h"

namespace lumatlas {

struct FrameSize {
  std::uint32_t width = 1920;  // pixels
  std::uint32_t height = 1080;
};

// Half way between consecutive stored views, looking as the first does with its field of view across, evenly spaced
// over the store. None if nothing is stored. Throws std::invalid_argument for a size without pixels.
[[nodiscard]] std::vector<Camera> cameras_between_views(const Snapshot& model, std::size_t count,
                                                        const FrameSize& size);

// The time of one picture, milliseconds. A software driver's threads belong to this process: with other work on the
// machine, compare the processor's time. On a GPU it says nothing.
struct PictureTime {
  double wall = 0, processor = 0;
};

// Measures the time from the call until the driver has finished.
[[nodiscard]] PictureTime time_picture(Renderer& renderer, const Camera& camera, const BlendOptions& blend);

// The time of several pictures, milliseconds.
struct FrameTime {
  double wall = 0, processor = 0;          // medians
  double wall_p95 = 0, processor_p95 = 0;  // 95th percentiles
};

// Draws each once, the first once before, because the first picture of a size sets up. Throws std::invalid_argument for
// no cameras.
[[nodiscard]] FrameTime frame_time(Renderer& renderer, const std::vector<Camera>& cameras, const BlendOptions& blend);

}  // namespace lumatlas
