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

// Times since an object was made, or since the last lap.
class Stopwatch {
 public:
  void lap(std::vector<CallTimes>& all, const std::string& what, std::uint64_t bytes = 0) {
    const double wall = ms_since(wall_), processor = thread_ms() - processor_;
    auto found = std::find_if(all.begin(), all.end(), [&](const CallTimes& times) { return times.what == what; });
    if (found == all.end()) found = all.insert(found, CallTimes{what});
    ++found->calls;
    found->wall += wall;
    found->longest_wall = std::max(found->longest_wall, wall);
    found->processor += processor;
    found->longest_processor = std::max(found->longest_processor, processor);
    found->most_bytes = std::max(found->most_bytes, bytes);
    *this = {};
  }

 private:
  std::chrono::steady_clock::time_point wall_ = std::chrono::steady_clock::now();
  double processor_ = thread_ms();
};

// Hears of the steps of upload() for as long as the object lives.
class StepListener {
 public:
  StepListener(Renderer& renderer, UploadListener listener) : renderer_(renderer) {
    renderer_.set_upload_listener(std::move(listener));
  }
  ~StepListener() { renderer_.set_upload_listener({}); }
  StepListener(const StepListener&) = delete;
  StepListener& operator=(const StepListener&) = delete;

 private:
  Renderer& renderer_;
};

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

std::vector<CallTimes> time_steps(Renderer& renderer, const Snapshot& snapshot, const Camera& camera,
                                  const BlendOptions& blend, double milliseconds) {
  std::vector<CallTimes> times;
  Stopwatch call, step;
  const Preparing preparing(renderer.begin(snapshot, blend));
  call.lap(times, "begin()");
  const StepListener listener(renderer, [&](const UploadStep& done) { step.lap(times, done.what, done.bytes); });
  bool whole = false;
  while (!whole) {
    call = step = {};
    whole = renderer.upload(milliseconds);
    call.lap(times, "upload()");
    renderer.draw(camera, blend);
    glFinish();
    call.lap(times, whole ? "last picture" : "picture");
  }
  return times;
}

}  // namespace lumatlas
