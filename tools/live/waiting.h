// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/live/: what waits for the threads of a LiveModel, and which of it is given up where there is too
// much.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "mesh/camera.h"
#include "planner/planner.h"
#include "tools/meshing/depth/depth_fusion.h"

namespace lumatlas {

using LiveClock = std::chrono::steady_clock;

// What a thread has spent its time on so far, milliseconds.
struct ViewsWork {
  double surfaces = 0, views = 0, depths = 0;
};

// A view that is chosen, or not decided yet.
struct WaitingView {
  std::string name;
  Camera camera;
  PhotographSource photograph;
  LiveClock::time_point offered;
  std::uint64_t number = 0;                 // of the offer
  double news = 0;                          // see LiveVerdict::news
  std::optional<std::uint64_t> for_depths;  // decided once the surface has this many of the given depth frames
  std::uint32_t counted = 0;                // see LiveCoverage::add_waiting()
  LiveClock::time_point ready;              // when it was decided
  ViewsWork work_before;                    // what the thread of the views had done then
};

struct WaitingDepth {
  std::string name;
  Camera camera;
  std::function<DepthImage()> depth;
};

// Returns the waiting view to give up: the one with the least news. Among views with about as little news it is the one
// whose camera is nearest to another's, and of those the later one. There must be at least one.
[[nodiscard]] std::size_t least_useful(std::span<const WaitingView> views);

// Returns the waiting frame whose camera is nearest to another's, the later one of the two. There must be at least one.
[[nodiscard]] std::size_t most_alike(std::span<const WaitingDepth> frames);

}  // namespace lumatlas
