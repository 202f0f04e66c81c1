// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/playback/playback.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <string>
#include <thread>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/requirement.h"
#include "mesh/visibility/visibility.h"
#include "planner/refinement/surface_deviation.h"
#include "tools/base/elapsed.h"
#include "tools/budget/gpu_budget.h"
#include "tools/live/playback/captured_stream.h"
#include "tools/meshing/depth/scene_depth.h"
#include "tools/pipeline/surface/surface_trust_shares.h"

namespace lumatlas {

namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kLook = std::chrono::milliseconds(50);  // between two questions whether to end
constexpr auto kTell = std::chrono::seconds(1);
constexpr Requirement playback_requires{"playback"};

class Player {
 public:
  Player(const CapturedStream& stream, const PlaybackOptions& options, const PlaybackCallbacks& callbacks,
         LiveModel& live, PlaybackRecord& record)
      : stream_(stream), options_(options), callbacks_(callbacks), live_(live), record_(record) {}

  void play() {
    for (const CapturedFrame& frame : stream_.frames) {
      if (!wait_until(frame.time)) break;
      show(frame);
    }
    record_.ended_early = record_.frames < stream_.frames.size();
    record_.seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    tell();
  }

 private:
  // Returns false if the stream is to end.
  bool wait_until(double time) {
    const Clock::time_point due =
        start_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(time / options_.speed));
    for (;;) {
      if (callbacks_.ended && callbacks_.ended()) return false;
      const Clock::time_point now = Clock::now();
      if (now >= next_tell_) tell();
      if (now >= due) {
        record_.late_ms.push_back(std::chrono::duration<double, std::milli>(now - due).count());
        return true;
      }
      std::this_thread::sleep_until(std::min<Clock::time_point>(due, now + kLook));
    }
  }

  void show(const CapturedFrame& frame) {
    time_ = frame.time;
    ++record_.frames;
    if (frame.depth) {
      const SceneDepth& depth = stream_.scene.depths[*frame.depth];
      live_.fuse(depth.camera, [&depth] { return read_depth(depth); });
    }
    if (!frame.view) return;
    const SceneView& view = stream_.scene.views[*frame.view];
    const Clock::time_point start = Clock::now();
    (void)live_.offer(view.name, view.camera, [&view] { return load_photograph(view); });
    record_.offer_ms.push_back(ms_since(start));
  }

  void tell() {
    next_tell_ = Clock::now() + kTell;
    if (!callbacks_.told) return;
    callbacks_.told({time_, stream_.frames.back().time, record_.frames, stream_.frames.size(), live_.status()});
  }

  const CapturedStream& stream_;
  const PlaybackOptions& options_;
  const PlaybackCallbacks& callbacks_;
  LiveModel& live_;
  PlaybackRecord& record_;
  Clock::time_point start_ = Clock::now(), next_tell_ = start_ + kTell;
  double time_ = 0;
};

// One entry for each photograph that was offered, in that order; those that nothing more is known of were rejected.
std::vector<PlannedView> planned_views(const CapturedStream& stream, const PlaybackRecord& record) {
  std::map<std::string, const LiveOutcome*> by_name;
  for (const LiveOutcome& outcome : record.outcomes) by_name[outcome.name] = &outcome;
  std::vector<PlannedView> planned;
  for (std::size_t i = 0; i < record.frames; ++i) {
    if (!stream.frames[i].view) continue;
    PlannedView& view = planned.emplace_back();
    view.name = stream.scene.views[*stream.frames[i].view].name;
    const auto found = by_name.find(view.name);
    if (found != by_name.end()) view.verdict = found->second->verdict;
  }
  return planned;
}

std::vector<SkippedView> unread_views(const PlaybackRecord& record) {
  std::vector<SkippedView> skipped;
  for (const LiveOutcome& outcome : record.outcomes) {
    if (!outcome.failure.empty()) skipped.push_back({outcome.name, outcome.failure});
  }
  std::sort(skipped.begin(), skipped.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return skipped;
}

void measure_trust(BuildResult& result) {
  SurfaceDeviation deviation = surface_deviation(result.snapshot);
  if (!deviation.any_measured()) return;
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(result.snapshot.surface->mesh);
  result.trust = trust_shares(result.snapshot, deviation, *visibility);
  result.snapshot.cell_deviation = std::move(deviation.of_cell);
}

BuildResult result_of(const CapturedStream& stream, const PlaybackOptions& options, LiveResult model,
                      const PlaybackRecord& record) {
  BuildResult result;
  result.snapshot = std::move(model.snapshot);
  if (!result.snapshot.surface) {
    throw InputError(stream.scene.root.string() + ": none of the depth images that were played makes a surface" +
                     (record.live.last_failure.empty() ? "" : ": " + record.live.last_failure));
  }
  result.options.max_views = options.live.max_views;
  result.options.planner = options.live.planner;
  result.options.hold_out = options.hold_out;
  result.options.refine = options.polish_steps > 0 ? RefineMode::joint : RefineMode::all;
  result.options.refine_lenses = false;
  result.options.texture_px.reset();
  result.effective = model.planner;
  result.mesh_file = stream.scene.root;
  result.planned = planned_views(stream, record);
  result.skipped = unread_views(record);
  result.scene_notes = stream.scene.notes;
  result.georeference = stream.scene.georeference;
  // Of a stream that was ended the photographs that did not come are none that the model lacks.
  result.views = record.ended_early ? result.planned.size() : stream.scene.views.size();
  result.masked_views = masked_views(stream.scene);
  result.listed_to_score = record.ended_early ? 0 : held_out_views(stream.scene);
  result.summed_coverage = model.summed_coverage;
  result.stored_bytes = model.stored_bytes;
  if (options.measure_deviation) measure_trust(result);
  result.gpu_bytes = GpuByteCount(result.snapshot.surface).of(result.snapshot);
  return result;
}

}  // namespace

void check(const PlaybackOptions& options) {
  check(options.live);
  playback_requires(std::isfinite(options.speed) && options.speed > 0, "speed", options.speed, "finite and above 0");
  playback_requires(std::isfinite(options.rate) && options.rate > 0, "rate", options.rate, "finite and above 0");
  if (options.hold_out) check(*options.hold_out);
}

Playback play_capture(const std::filesystem::path& folder, PlaybackOptions options,
                      const PlaybackCallbacks& callbacks) {
  check(options);
  const Clock::time_point start = Clock::now();
  const CapturedStream stream = read_captured_stream(folder, options.pictures, options.hold_out, options.rate);
  options.live.surface.offset = stream.offset;
  Playback playback;
  PlaybackRecord& record = playback.record;
  LiveModel live(options.live);
  std::shared_ptr<void> watch = callbacks.watch ? callbacks.watch(live) : nullptr;
  Player(stream, options, callbacks, live, record).play();
  const Clock::time_point end = Clock::now();
  LiveResult model = live.finish(options.polish_steps);
  watch.reset();
  record.outcomes = live.take_outcomes();
  record.live = live.status();
  playback.result = result_of(stream, options, std::move(model), record);
  record.finish_ms = ms_since(end);
  playback.result.total_ms = ms_since(start);
  return playback;
}

}  // namespace lumatlas
