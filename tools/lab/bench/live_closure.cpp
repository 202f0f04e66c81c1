// SPDX-License-Identifier: GPL-3.0-or-later
// Benchmark of a loop closure: a stream with a drift is fed to a live model, and then all poses are taken back at once,
// while a viewer draws. Tells how long it takes until snapshots have stored views and surface at the new poses, until
// the viewer shows them, until all depth images are fused at their new poses, and until snapshots have the surface that
// is made of them; and the viewer's frames meanwhile, against those before. A table in Markdown goes to stdout; exit
// status as of lumatlas itself.
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <glm/glm.hpp>
#include <iomanip>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "blend/gl/egl_context.h"
#include "blend/next_snapshot.h"
#include "blend/renderer.h"
#include "mesh/base/errors.h"
#include "mesh/base/median.h"
#include "mesh/base/thread_priority.h"
#include "tools/lab/bench/program.h"
#include "tools/live/live_model.h"
#include "tools/live/playback/captured_stream.h"
#include "tools/meshing/depth/scene_depth.h"

namespace lumatlas {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kUploadMs = 4;  // of each of the viewer's frames, for the next snapshot

struct ClosureFlags {
  std::filesystem::path folder;
  std::uint32_t frames = 150, views = 100, width = 160;
  double shift = 0.15, turn = 0.03;  // of the last frame: scene units, and radians about the third axis
  double seconds = 10;               // of the viewer before the closure
  std::uint32_t rest = 0;            // of the viewer after each frame, milliseconds
};

double ms_between(Clock::time_point a, Clock::time_point b) {
  return std::chrono::duration<double, std::milli>(b - a).count();
}

// The pose of a camera whose world has moved by this share of the drift.
Camera drifted(Camera camera, const ClosureFlags& flags, double share) {
  const double angle = flags.turn * share;
  const glm::dmat3 turn(std::cos(angle), std::sin(angle), 0, -std::sin(angle), std::cos(angle), 0, 0, 0, 1);
  camera.cam_from_world_translation +=
      camera.cam_from_world_rotation * (flags.shift * share * glm::normalize(glm::dvec3(0.7, -0.6, 0.4)));
  camera.cam_from_world_rotation = camera.cam_from_world_rotation * turn;
  return camera;
}

// Draws the model over and over on a thread of its own, and notes each frame.
class Viewer {
 public:
  struct Frame {
    Clock::time_point start, end;
    double snapshot_ms = 0;                  // the call for the model as it is now
    double load_ms = 0;                      // of its way to the renderer, in this frame
    std::shared_ptr<const Surface> surface;  // that it shows
  };

  Viewer(const LiveModel& live, const Camera& camera, std::chrono::milliseconds rest)
      : live_(live), camera_(camera), rest_(rest), thread_([this] {
          try {
            watch();
          } catch (...) {
            failure_ = std::current_exception();
            ended_ = true;
          }
        }) {}
  ~Viewer() { join(); }
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  void wait_for_first_frame() const {
    while (!drew_ && !ended_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  // Ends the viewer. Throws what ended it before.
  std::vector<Frame> frames() {
    join();
    if (failure_) std::rethrow_exception(failure_);
    return std::move(frames_);
  }

 private:
  void join() {
    ended_ = true;
    if (thread_.joinable()) thread_.join();
  }

  void watch() {
    const EglContext context;
    Renderer renderer({.join_cells = false});  // as once a store has changed
    std::shared_ptr<const Snapshot> shown = live_.snapshot(), coming;
    renderer.load(*shown);
    std::optional<NextSnapshot> next;  // that is on its way to the renderer
    std::thread preparing;
    const auto end_preparing = [&] {
      if (next) next->cancel();
      if (preparing.joinable()) preparing.join();
    };
    try {
      while (!ended_) {
        Frame frame;
        frame.start = Clock::now();
        if (!next) {
          coming = live_.snapshot();
          next = renderer.begin(*coming, {});
          preparing = std::thread([preparation = *next]() mutable { prepare(preparation); });
        }
        const Clock::time_point taken = Clock::now();
        frame.snapshot_ms = ms_between(frame.start, taken);
        const bool is_whole = renderer.upload(kUploadMs);
        frame.load_ms = ms_between(taken, Clock::now());
        if (is_whole) shown = coming;
        frame.surface = shown->surface;
        (void)renderer.render(camera_, {});
        frame.end = Clock::now();
        frames_.push_back(frame);
        drew_ = true;
        std::this_thread::sleep_for(rest_);
        if (!is_whole) continue;
        preparing.join();
        next.reset();
      }
    } catch (...) {
      end_preparing();
      throw;
    }
    end_preparing();
  }

  // Gives way to the thread that draws. upload() throws what this thread cannot.
  static void prepare(NextSnapshot& next) {
    lower_thread_priority();
    try {
      tbb::task_arena(1).execute([&] { next.prepare(); });
    } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch)
    }
  }

  const LiveModel& live_;
  Camera camera_;
  std::chrono::milliseconds rest_;
  std::atomic<bool> ended_ = false, drew_ = false;
  std::vector<Frame> frames_;
  std::exception_ptr failure_;
  std::thread thread_;
};

template <typename Done>
void wait_until(const Done& done) {
  while (!done()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

// Feeds the frames with their drift, and waits until all has been worked off.
std::vector<MovedView> feed(LiveModel& live, const CapturedStream& stream, const ClosureFlags& flags) {
  std::vector<MovedView> truth;
  const std::size_t count = std::min<std::size_t>(flags.frames, stream.frames.size());
  for (std::size_t i = 0; i < count; ++i) {
    const CapturedFrame& frame = stream.frames[i];
    if (!frame.view || !frame.depth) continue;
    const SceneView& view = stream.scene.views[*frame.view];
    const SceneDepth& depth = stream.scene.depths[*frame.depth];
    const double share = static_cast<double>(i) / static_cast<double>(count);
    truth.push_back({view.name, view.camera});
    live.fuse(view.name, drifted(depth.camera, flags, share), [&depth] { return read_flat_depth(depth); });
    (void)live.offer(view.name, drifted(view.camera, flags, share), [&view] { return load_photograph(view); });
    wait_until([&] {
      const LiveStatus status = live.status();
      return status.waiting < 4 && status.fusion.count + 2 > status.depths_given;
    });
  }
  // The last surface has come, and what it changed is renewed, when nothing has happened for a while.
  std::uint64_t before = 0;
  wait_until([&] {
    std::this_thread::sleep_for(std::chrono::seconds(3));
    const LiveStatus status = live.status();
    const std::uint64_t work = status.storing.count + status.surface_taking.count + status.depth_renewing.count;
    return status.waiting == 0 && std::exchange(before, work) == work;
  });
  return truth;
}

void print_row(const std::string& when, double seconds, const std::vector<Viewer::Frame>& frames,
               Clock::time_point from, Clock::time_point to) {
  std::vector<double> whole, snapshots, loads;
  for (const Viewer::Frame& frame : frames) {
    if (frame.end < from || frame.start > to) continue;
    whole.push_back(ms_between(frame.start, frame.end));
    snapshots.push_back(frame.snapshot_ms);
    loads.push_back(frame.load_ms);
  }
  if (whole.empty()) return;
  std::cout << "| " << when << " | " << seconds << " | " << whole.size() << " | " << upper_median(whole) << " | "
            << *std::max_element(whole.begin(), whole.end()) << " | "
            << *std::max_element(snapshots.begin(), snapshots.end()) << " | "
            << *std::max_element(loads.begin(), loads.end()) << " |\n";
}

void print_work(const std::string& what, const LiveTimes& before, const LiveTimes& after) {
  const std::uint64_t count = after.count - before.count;
  if (count == 0) return;
  std::cout << "| " << what << " | " << count << " | " << (after.total - before.total) / static_cast<double>(count)
            << " | " << after.worst << " |\n";
}

void run(const ClosureFlags& flags) {
  if (!(std::isfinite(flags.shift) && std::isfinite(flags.turn) && (flags.shift != 0 || flags.turn != 0))) {
    throw InputError("--shift and --turn must be finite, and one of them not 0: without a drift nothing is taken back");
  }
  const CapturedStream stream = read_captured_stream(flags.folder, {}, std::nullopt, 10);
  LiveOptions options;
  options.max_views = flags.views;
  options.surface.offset = stream.offset;
  LiveModel live(options);
  std::vector<MovedView> truth = feed(live, stream, flags);
  const LiveStatus fed = live.status();
  if (fed.held == 0) throw std::runtime_error("no view of the stream was stored");
  const Camera camera = truth[truth.size() / 2].camera.shrunk_to(flags.width);
  Viewer viewer(live, camera, std::chrono::milliseconds(flags.rest));
  viewer.wait_for_first_frame();  // for which its programs are made
  const Clock::time_point start = Clock::now();
  std::this_thread::sleep_for(std::chrono::duration<double>(flags.seconds));
  const Clock::time_point closed = Clock::now();
  live.move_views(truth);
  const double call_ms = ms_between(closed, Clock::now());
  wait_until([&] { return live.status().moving.count > fed.moving.count; });
  const Clock::time_point consistent = Clock::now();
  wait_until([&] {
    const LiveStatus status = live.status();
    return status.surface_rests || (status.depths_to_move == 0 && status.fusing_again.count > 0);
  });
  const Clock::time_point fused = Clock::now();
  wait_until([&] { return live.status().surface_rests; });
  const Clock::time_point followed = Clock::now();
  const LiveStatus done = live.status();
  const std::vector<Viewer::Frame> frames = viewer.frames();
  std::cout << std::fixed << std::setprecision(1) << "move_views() of " << fed.held << " views and " << fed.fusion.count
            << " depth images, " << fed.faces << " faces: " << call_ms << " ms\n\n"
            << "| viewer's frames | seconds | frames | median, ms | longest | longest snapshot() | longest upload() |\n"
               "|---|---|---|---|---|---|---|\n";
  print_row("before", ms_between(start, closed) / 1000, frames, start, closed);
  print_row("until snapshots have the poses", ms_between(closed, consistent) / 1000, frames, closed, consistent);
  const auto showing = std::find_if(frames.begin(), frames.end(),
                                    [&](const Viewer::Frame& frame) { return frame.surface != frames[0].surface; });
  if (showing != frames.end()) {
    print_row("until the viewer shows them", ms_between(closed, showing->end) / 1000, frames, closed, showing->end);
  }
  print_row("until the depth images are fused again", ms_between(closed, fused) / 1000, frames, closed, fused);
  print_row("until the surface has followed", ms_between(closed, followed) / 1000, frames, closed, followed);
  std::cout << "\n| meanwhile | how many | mean, ms | longest of all |\n|---|---|---|---|\n";
  print_work("stored views and surface moved", fed.moving, done.moving);
  print_work("depth images fused again", fed.fusing_again, done.fusing_again);
  print_work("surfaces made", fed.surface_making, done.surface_making);
  print_work("surfaces taken over", fed.surface_taking, done.surface_taking);
  print_work("depths of stored views renewed", fed.depth_renewing, done.depth_renewing);
}

}  // namespace

}  // namespace lumatlas

int main(int argc, char** argv) {
  using namespace lumatlas;
  CLI::App program("Measures a loop closure of a live model while a viewer draws it", "bench_live_closure");
  ClosureFlags flags;
  program.add_option("STREAM", flags.folder, "Capture with depth images, as `lumatlas synth lab --stream` writes it")
      ->required();
  program.add_option("--frames", flags.frames, "Frames of the stream, at most")->capture_default_str();
  program.add_option("--views", flags.views, "Photographs that the model keeps")->capture_default_str();
  program.add_option("--width", flags.width, "Longest side of the viewer's picture, pixels")->capture_default_str();
  program.add_option("--shift", flags.shift, "Drift at the last frame, scene units")->capture_default_str();
  program.add_option("--turn", flags.turn, "Drift at the last frame, radians")->capture_default_str();
  program.add_option("--seconds", flags.seconds, "Time that the viewer draws before the closure")
      ->capture_default_str();
  program
      .add_option("--rest", flags.rest,
                  "Time that the viewer rests after each frame, ms: one with a GPU takes no cores")
      ->capture_default_str();
  return run_program(program, "bench_live_closure", argc, argv, [&] { run(flags); });
}
