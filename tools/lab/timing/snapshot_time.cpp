// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/timing/snapshot_time.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <exception>
#include <thread>
#include <utility>

#include "tools/base/elapsed.h"

namespace lumatlas {

namespace {

double thread_ms() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

// Counts a frame in which `work` is done.
template <typename Work>
void count_frame(SnapshotTime& longest, const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  const double thread_start = thread_ms();
  work();
  glFinish();
  longest.wall = std::max(longest.wall, ms_since(start));
  longest.processor = std::max(longest.processor, thread_ms() - thread_start);
  ++longest.frames;
}

// Prepares a snapshot for as long as the object lives; its end gives up what is not done yet.
class Preparing {
 public:
  explicit Preparing(NextSnapshot next) : next_(std::move(next)) {
    thread_ = std::thread([this] {
      try {
        next_.prepare();
      } catch (const std::exception&) {  // upload() throws the same
      }
    });
  }
  ~Preparing() {
    next_.cancel();
    thread_.join();
  }
  Preparing(const Preparing&) = delete;
  Preparing& operator=(const Preparing&) = delete;

 private:
  NextSnapshot next_;
  std::thread thread_;
};

}  // namespace

SnapshotTime time_at_once(Renderer& renderer, const Snapshot& snapshot, const BlendOptions& blend) {
  SnapshotTime time;
  count_frame(time, [&] {
    renderer.load(snapshot);
    renderer.make_ready(blend);
  });
  return time;
}

SnapshotTime time_in_pieces(Renderer& renderer, const Snapshot& snapshot, const Camera& camera,
                            const BlendOptions& blend, double milliseconds) {
  SnapshotTime time;
  const Preparing preparing(renderer.begin(snapshot, blend));
  bool whole = false;
  while (!whole) {
    count_frame(time, [&] { whole = renderer.upload(milliseconds); });
    renderer.draw(camera, blend);
    glFinish();
  }
  return time;
}

}  // namespace lumatlas
