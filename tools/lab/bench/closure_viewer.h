// SPDX-License-Identifier: GPL-3.0-or-later
// A viewer of a live model that takes its snapshots piece by piece, and notes how long each of its frames took.
#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <memory>
#include <thread>
#include <vector>

#include "blend/rendering.h"
#include "mesh/camera/camera.h"
#include "tools/live/live_model.h"

namespace lumatlas {

// Draws the model over and over on a thread of its own.
class ClosureViewer {
 public:
  using Time = std::chrono::steady_clock::time_point;
  struct Frame {
    Time start, end;
    double snapshot_ms = 0;                  // the call for the model as it is now
    double load_ms = 0;                      // of its way to the renderer, in this frame
    std::shared_ptr<const Surface> surface;  // that it shows
  };
  struct Picture {
    Time time;
    Rendering rendering;
  };

  // The model must outlive this, and have a snapshot. The viewer rests after each frame, and keeps the first picture of
  // each surface and the last of all, if it is to.
  ClosureViewer(const LiveModel& live, const Camera& camera, std::chrono::milliseconds rest, bool keeps_pictures);
  ~ClosureViewer() { join(); }
  ClosureViewer(const ClosureViewer&) = delete;
  ClosureViewer& operator=(const ClosureViewer&) = delete;

  void wait_for_first_frame() const;
  // Ends the viewer, and returns its frames. Throws what ended it before.
  [[nodiscard]] std::vector<Frame> end();
  // After end().
  [[nodiscard]] const std::vector<Picture>& pictures() const { return pictures_; }

 private:
  void join();
  void watch();

  const LiveModel& live_;
  Camera camera_;
  std::chrono::milliseconds rest_;
  bool keeps_pictures_;
  std::atomic<bool> ended_ = false, drew_ = false;
  std::vector<Frame> frames_;
  std::vector<Picture> pictures_;
  std::exception_ptr failure_;
  std::thread thread_;
};

}  // namespace lumatlas
