// SPDX-License-Identifier: GPL-3.0-or-later
// Benchmark of a loop closure: a stream with a drift is fed to a live model, and then all poses are taken back at once,
// while a viewer draws. Tells how long it takes until snapshots have stored views and surface at the new poses, until
// the viewer shows them, until all depth images are fused at their new poses, and until snapshots have the surface that
// is made of them; and the viewer's frames meanwhile, against those before. A table in Markdown goes to stdout; exit
// status as of lumatlas itself.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <iomanip>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/median.h"
#include "tools/lab/bench/closure_viewer.h"
#include "tools/lab/bench/program.h"
#include "tools/live/live_model.h"
#include "tools/live/playback/captured_stream.h"
#include "tools/meshing/depth/scene_depth.h"
#include "tools/score/measures/scores.h"

namespace lumatlas {

namespace {

using Clock = std::chrono::steady_clock;
using Frame = ClosureViewer::Frame;

struct ClosureFlags {
  std::filesystem::path folder;
  std::uint32_t frames = 150, views = 100, width = 160;
  double shift = 0.15, turn = 0.03;  // of the last frame: scene units, and radians about the third axis
  double seconds = 10;               // of the viewer before the closure
  std::uint32_t rest = 0;            // of the viewer after each frame, milliseconds
  std::filesystem::path pictures;    // folder; empty: none
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

void print_row(const std::string& when, double seconds, const std::vector<Frame>& frames, Clock::time_point from,
               Clock::time_point to) {
  std::vector<double> whole, snapshots, loads;
  for (const Frame& frame : frames) {
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

// Writes the viewer's pictures, and the photograph that was taken from there.
void write_pictures(const std::vector<ClosureViewer::Picture>& pictures, Clock::time_point closed,
                    const Photograph& photograph, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  write_image(folder / "photograph.png", photograph);
  std::cout << "\n| picture | seconds after the closure | PSNR where there is a surface, dB |\n|---|---|---|\n";
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const auto& [time, rendering] = pictures[i];
    const std::string name = "picture-" + std::to_string(i) + ".png";
    write_image(folder / name, rendering.picture);
    std::vector<std::uint8_t> surface;
    for (const PixelState state : rendering.state) surface.push_back(state != PixelState::empty ? 255 : 0);
    std::cout << "| " << name << " | " << ms_between(closed, time) / 1000 << " | "
              << psnr(rendering.picture, photograph, surface) << " |\n";
  }
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
  const SceneView& looked_at = stream.scene.views[truth.size() / 2];
  const bool has_pictures = !flags.pictures.empty();
  const Camera camera = has_pictures ? looked_at.camera : looked_at.camera.shrunk_to(flags.width);
  ClosureViewer viewer(live, camera, std::chrono::milliseconds(flags.rest), has_pictures);
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
  const std::vector<Frame> frames = viewer.end();
  std::cout << std::fixed << std::setprecision(1) << "move_views() of " << fed.held << " views and " << fed.fusion.count
            << " depth images, " << fed.faces << " faces: " << call_ms << " ms\n\n"
            << "| viewer's frames | seconds | frames | median, ms | longest | longest snapshot() | longest upload() |\n"
               "|---|---|---|---|---|---|---|\n";
  print_row("before", ms_between(start, closed) / 1000, frames, start, closed);
  print_row("until snapshots have the poses", ms_between(closed, consistent) / 1000, frames, closed, consistent);
  const auto showing = std::find_if(frames.begin(), frames.end(),
                                    [&](const Frame& frame) { return frame.surface != frames[0].surface; });
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
  if (has_pictures) write_pictures(viewer.pictures(), closed, load_photograph(looked_at), flags.pictures);
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
  program.add_option("--pictures", flags.pictures,
                     "Folder for the first picture of each surface and the last of all, as large as the photographs");
  return run_program(program, "bench_live_closure", argc, argv, [&] { run(flags); });
}
