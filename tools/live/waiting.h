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

#include "mesh/camera/camera.h"
#include "planner/planner.h"
#include "tools/meshing/depth/depth_fusion.h"

namespace lumatlas {

using LiveClock = std::chrono::steady_clock;

[[nodiscard]] inline double ms_of(LiveClock::duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

// What a thread has spent its time on so far, milliseconds.
struct ViewsWork {
  double surfaces = 0, moves = 0, views = 0, depths = 0;
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
  std::optional<std::uint32_t> counted;     // see LiveCoverage::add_waiting(); none without a surface
  LiveClock::time_point ready;              // when it was decided; of a view that is not decided, when it came
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

// Returns the view to give up; none if at most `most` views wait, and at most `most_decided` of these are decided.
[[nodiscard]] std::optional<std::size_t> one_too_many(std::span<const WaitingView> views, std::size_t most,
                                                      std::size_t most_decided);

// Returns how urgent it is to store a view: its news, and the time that it has been ready in units of the longest wait,
// so that a view with little news does not stay behind others with more news.
[[nodiscard]] double urgency(const WaitingView& view, LiveClock::time_point now,
                             std::chrono::milliseconds longest_wait);

// Measures how long the thread of the views takes for a view, with the surfaces and depths that come between. New poses
// do not count: a loop closure is rare, and says nothing of how long the next views take.
class StoringPace {
 public:
  // Tells that a view was stored, and what the thread had done by then.
  void note_stored(const WaitingView& view, LiveClock::time_point now, const ViewsWork& work);
  // Returns how many decided views may wait, so that the last of them is stored within the longest wait: 4 at least,
  // and any number before the first view was stored.
  [[nodiscard]] std::size_t most_decided(std::chrono::milliseconds longest_wait) const;

 private:
  std::optional<double> mean_ms_;  // of the last views
  LiveClock::time_point last_stored_{};
  double moves_then_ = 0;  // ViewsWork::moves when the last view was stored
};

// Returns the waiting frame whose camera is nearest to another's, the later one of the two. There must be at least one.
[[nodiscard]] std::size_t most_alike(std::span<const WaitingDepth> frames);

}  // namespace lumatlas
