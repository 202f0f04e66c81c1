// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/bench/closure_viewer.h"

#include <tbb/task_arena.h>

#include <optional>
#include <utility>

#include "blend/gl/egl_context.h"
#include "blend/next_snapshot.h"
#include "blend/renderer.h"
#include "mesh/base/thread_priority.h"

namespace lumatlas {

namespace {

constexpr double kUploadMs = 4;  // of each frame, for the next snapshot

// Gives way to the thread that draws. upload() throws what this thread cannot.
void prepare_behind(NextSnapshot& next) {
  lower_thread_priority();
  try {
    tbb::task_arena(1).execute([&] { next.prepare(); });
  } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch)
  }
}

// Gives snapshots to a renderer, one after another.
class SnapshotFeed {
 public:
  SnapshotFeed(const LiveModel& live, Renderer& renderer) : live_(live), renderer_(renderer), shown_(live.snapshot()) {
    renderer_.load(*shown_);
  }
  ~SnapshotFeed() {
    if (next_) next_->cancel();
    if (preparing_.joinable()) preparing_.join();
  }
  SnapshotFeed(const SnapshotFeed&) = delete;
  SnapshotFeed& operator=(const SnapshotFeed&) = delete;

  // Takes the model as it is now, unless a snapshot is on its way.
  void begin() {
    if (next_) return;
    coming_ = live_.snapshot();
    next_ = renderer_.begin(*coming_, {});
    preparing_ = std::thread([preparation = *next_]() mutable { prepare_behind(preparation); });
  }
  void upload() {
    if (!renderer_.upload(kUploadMs)) return;
    shown_ = coming_;
    preparing_.join();
    next_.reset();
  }
  [[nodiscard]] const std::shared_ptr<const Surface>& surface() const { return shown_->surface; }

 private:
  const LiveModel& live_;
  Renderer& renderer_;
  std::shared_ptr<const Snapshot> shown_, coming_;
  std::optional<NextSnapshot> next_;
  std::thread preparing_;
};

double ms_from(ClosureViewer::Time start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

ClosureViewer::ClosureViewer(const LiveModel& live, const Camera& camera, std::chrono::milliseconds rest,
                             bool keeps_pictures)
    : live_(live), camera_(camera), rest_(rest), keeps_pictures_(keeps_pictures), thread_([this] {
        try {
          watch();
        } catch (...) {
          failure_ = std::current_exception();
          ended_ = true;
        }
      }) {}

void ClosureViewer::wait_for_first_frame() const {
  while (!drew_ && !ended_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

std::vector<ClosureViewer::Frame> ClosureViewer::end() {
  join();
  if (failure_) std::rethrow_exception(failure_);
  return std::move(frames_);
}

void ClosureViewer::join() {
  ended_ = true;
  if (thread_.joinable()) thread_.join();
}

void ClosureViewer::watch() {
  const EglContext context;
  Renderer renderer({.join_cells = false});  // as once a store has changed
  SnapshotFeed feed(live_, renderer);
  std::optional<Picture> last;
  while (!ended_) {
    Frame frame;
    frame.start = std::chrono::steady_clock::now();
    feed.begin();
    frame.snapshot_ms = ms_from(frame.start);
    const Time taken = std::chrono::steady_clock::now();
    feed.upload();
    frame.load_ms = ms_from(taken);
    frame.surface = feed.surface();
    Rendering rendering = renderer.render(camera_, {});
    frame.end = std::chrono::steady_clock::now();
    const bool is_first = frames_.empty() || frames_.back().surface != frame.surface;
    frames_.push_back(std::move(frame));
    if (keeps_pictures_) {
      last = {frames_.back().end, std::move(rendering)};
      if (is_first) pictures_.push_back(std::move(*std::exchange(last, std::nullopt)));
    }
    drew_ = true;
    std::this_thread::sleep_for(rest_);
  }
  if (last) pictures_.push_back(std::move(*last));
}

}  // namespace lumatlas
