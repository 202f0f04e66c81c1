// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/playback/playback.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/glm.hpp>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <variant>

#include "mesh/base/errors.h"
#include "mesh/base/median.h"
#include "mesh/base/requirement.h"
#include "mesh/visibility/visibility.h"
#include "planner/refinement/surface_deviation.h"
#include "tools/base/elapsed.h"
#include "tools/base/process/machine.h"
#include "tools/budget/gpu_budget.h"
#include "tools/live/playback/captured_stream.h"
#include "tools/live/playback/finished_model.h"
#include "tools/live/playback/frame_message.h"
#include "tools/live/playback/kept_frames.h"
#include "tools/meshing/depth/scene_depth.h"
#include "tools/pipeline/surface/surface_trust_shares.h"

namespace lumatlas {

namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kLook = std::chrono::milliseconds(50);  // between two questions whether to end
constexpr auto kTell = std::chrono::seconds(1);
constexpr Requirement playback_requires{"playback"};

// Notes how the stream stands now. `told` is the number of offers at the moment before, and becomes that of this one.
void note_moment(double seconds, const LiveStatus& live, std::size_t& told, PlaybackRecord& record) {
  PlaybackMoment moment;
  moment.seconds = seconds;
  moment.frames = record.frames;
  std::vector<double> offers(record.offer_ms.begin() + static_cast<std::ptrdiff_t>(told), record.offer_ms.end());
  told = record.offer_ms.size();
  if (!offers.empty()) {
    moment.offer_worst_ms = *std::max_element(offers.begin(), offers.end());
    moment.offer_median_ms = upper_median(offers);
  }
  moment.depths_given = live.depths_given;
  moment.depths_fused = live.fusion.count;
  moment.held = live.held;
  moment.waiting = live.waiting;
  moment.faces = live.faces;
  moment.summed_coverage = live.summed_coverage;
  moment.resident_bytes = resident_bytes();
  record.moments.push_back(moment);
}

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
      live_.fuse({}, depth.camera, [&depth] { return read_flat_depth(depth); });
    }
    if (!frame.view) return;
    const SceneView& view = stream_.scene.views[*frame.view];
    const Clock::time_point start = Clock::now();
    (void)live_.offer(view.name, view.camera, [&view] { return load_photograph(view); });
    record_.offer_ms.push_back(ms_since(start));
  }

  void tell() {
    next_tell_ = Clock::now() + kTell;
    const LiveStatus status = live_.status();
    note_moment(std::chrono::duration<double>(Clock::now() - start_).count(), status, offers_told_, record_);
    if (!callbacks_.told) return;
    callbacks_.told({time_, stream_.frames.back().time, record_.frames, stream_.frames.size(), status});
  }

  const CapturedStream& stream_;
  const PlaybackOptions& options_;
  const PlaybackCallbacks& callbacks_;
  LiveModel& live_;
  PlaybackRecord& record_;
  Clock::time_point start_ = Clock::now(), next_tell_ = start_ + kTell;
  double time_ = 0;
  std::size_t offers_told_ = 0;
};

// Names the source of the frames, and the photographs that were offered.
struct PlayedSource {
  SceneViews scene;  // of a capture; empty for a client, except for its root
  std::vector<std::string> offered;
};

// One entry for each photograph that was offered, in that order; those that nothing more is known of were rejected.
std::vector<PlannedView> planned_views(const PlayedSource& source, const PlaybackRecord& record) {
  std::map<std::string, const LiveOutcome*> by_name;
  for (const LiveOutcome& outcome : record.outcomes) by_name[outcome.name] = &outcome;
  std::vector<PlannedView> planned;
  for (const std::string& name : source.offered) {
    PlannedView& view = planned.emplace_back();
    view.name = name;
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

// Returns the options of a build that makes the same of a stream's frames at rest.
BuildOptions build_options_of(const PlaybackOptions& options) {
  BuildOptions build;
  build.max_views = options.live.max_views;
  build.planner = options.live.planner;
  build.hold_out = options.hold_out;
  build.refine = options.polish_steps > 0 ? RefineMode::joint : RefineMode::all;
  if (options.polish_steps > 0) build.max_polish_steps = options.polish_steps;
  build.measure_deviation = options.measure_deviation;
  build.texture_px.reset();
  build.memory.scratch_folder = options.scratch_folder;
  return build;
}

// Adds what a result says of the stream that it is of.
void note_source(const PlayedSource& source, const PlaybackRecord& record, BuildResult& result) {
  result.skipped = unread_views(record);
  result.scene_notes = source.scene.notes;
  result.georeference = source.scene.georeference;
  result.snapshot.georeference = result.georeference;
  // The model of a stream that was ended early does not lack the photographs that had not come.
  result.views = record.ended_early ? result.planned.size() : source.scene.views.size();
  result.masked_views = masked_views(source.scene);
  result.listed_to_score = record.ended_early ? 0 : held_out_views(source.scene);
}

BuildResult result_of(const PlayedSource& source, const PlaybackOptions& options, LiveResult model,
                      const PlaybackRecord& record) {
  BuildResult result;
  result.snapshot = std::move(model.snapshot);
  if (!result.snapshot.surface) {
    throw InputError(source.scene.root.string() + ": nothing that arrived gives a surface" +
                     (record.live.last_failure.empty() ? "" : ": " + record.live.last_failure));
  }
  result.options = build_options_of(options);
  result.options.refine_lenses = result.options.refine_shutters = false;
  result.options.completion.far_sphere = false;
  result.effective = model.planner;
  result.mesh_file = source.scene.root;
  result.planned = planned_views(source, record);
  note_source(source, record, result);
  result.summed_coverage = model.summed_coverage;
  result.stored_bytes = model.stored_bytes;
  result.gpu_bytes = GpuByteCount(result.snapshot.surface).of(result.snapshot);
  return result;
}

// Makes the model anew of the frames. Where that fails, it stays as the stream left it.
void make_anew(StreamedFrames frames, const PlayedSource& source, const PlaybackOptions& options,
               const PlaybackCallbacks& callbacks, Playback& playback) {
  PlaybackRecord& record = playback.record;
  std::set<std::string> unread;
  for (const SkippedView& view : playback.result.skipped) unread.insert(view.name);
  std::erase_if(frames.offered, [&](std::size_t rank) { return unread.contains(frames.scene.views[rank].name); });
  if (frames.offered.empty()) return;
  if (frames.scene.depths.empty() && !frames.surface) {
    record.finish.why_not = "no depth image of the stream is kept";
    return;
  }
  if (callbacks.finishing) callbacks.finishing(frames.scene.depths.size(), frames.offered.size());
  const StageProgress unheard = [](const std::string& /*stage*/, std::size_t /*steps*/) {
    return [](std::size_t /*done*/) {};
  };
  try {
    FinishedModel finished = finished_model(std::move(frames), build_options_of(options),
                                            callbacks.fusing ? callbacks.fusing : unheard, callbacks.building);
    record.finish = {true, {}, finished.voxel, finished.fusing_ms, finished.building_ms};
    playback.result = std::move(finished.result);
    note_source(source, record, playback.result);
  } catch (const InputError& error) {
    record.finish.why_not = error.what();
  } catch (const BuildStopped&) {
    record.finish.why_not = "it was asked to stop";
  }
}

// Works off what waits, and makes the result, anew where there are frames.
void finish_playback(LiveModel& live, std::shared_ptr<void>& watch, const PlayedSource& source,
                     std::optional<StreamedFrames> frames, const PlaybackOptions& options,
                     const PlaybackCallbacks& callbacks, Playback& playback) {
  const Clock::time_point end = Clock::now();
  // A model that is made anew is refined after that.
  const bool is_made_anew = frames.has_value();
  LiveResult model = live.finish(is_made_anew ? 0 : options.polish_steps, !is_made_anew);
  watch.reset();
  PlaybackRecord& record = playback.record;
  record.outcomes = live.take_outcomes();
  record.live = live.status();
  playback.result = result_of(source, options, std::move(model), record);
  if (frames && record.live.pieces_given > 0) frames->surface = playback.result.snapshot.surface;
  if (frames) make_anew(std::move(*frames), source, options, callbacks, playback);
  if (options.measure_deviation && !record.finish.done) measure_trust(playback.result);
  record.finish_ms = ms_since(end);
}

// Returns the frames that were played, in the capture's own coordinates.
StreamedFrames played_frames(const CapturedStream& stream, std::size_t played) {
  StreamedFrames frames;
  std::set<std::size_t> views, depths;
  for (std::size_t i = 0; i < played; ++i) {
    if (stream.frames[i].view) views.insert(*stream.frames[i].view);
    if (stream.frames[i].depth) depths.insert(*stream.frames[i].depth);
  }
  const auto unmoved = [&](Camera camera) {
    camera.cam_from_world_translation -= camera.cam_from_world_rotation * stream.offset;
    return camera;
  };
  frames.scene.root = stream.scene.root;
  frames.scene.form = stream.scene.form;
  std::map<std::size_t, std::size_t> rank_of;
  for (const std::size_t view : views) {
    rank_of[view] = frames.scene.views.size();
    frames.scene.views.push_back(stream.scene.views[view]);
    frames.scene.views.back().camera = unmoved(stream.scene.views[view].camera);
  }
  for (const std::size_t depth : depths) {
    frames.scene.depths.push_back(stream.scene.depths[depth]);
    frames.scene.depths.back().camera = unmoved(stream.scene.depths[depth].camera);
  }
  for (std::size_t i = 0; i < played; ++i) {
    if (stream.frames[i].view) frames.offered.push_back(rank_of.at(*stream.frames[i].view));
  }
  return frames;
}

std::filesystem::path scratch_folder_of(const PlaybackOptions& options) {
  return options.scratch_folder.empty() ? std::filesystem::temp_directory_path() : options.scratch_folder;
}

DepthImage depth_of(const FrameMessage& frame) {
  std::vector<float> depth;
  depth.reserve(frame.depth.size());
  for (const std::uint16_t value : frame.depth) depth.push_back(static_cast<float>(frame.depth_unit * value));
  return {frame.camera, std::move(depth)};
}

// Takes messages of clients, one client after the other, until one of them says that the stream ends.
class Receiver {
 public:
  Receiver(FrameSource& from, PlaybackOptions& options, const PlaybackCallbacks& callbacks)
      : from_(from), options_(options), callbacks_(callbacks) {
    source_.scene.root = "the stream";
  }

  Playback receive() {
    while (!ended_ && !(callbacks_.ended && callbacks_.ended())) {
      take(received());
      if (Clock::now() >= next_tell_) tell();
    }
    tell();
    Playback playback;
    playback.record = std::move(record_);
    playback.record.ended_early = !ended_;
    playback.record.seconds = seconds();
    if (!live_) throw InputError("no frame arrived, so no model was saved");
    std::optional<StreamedFrames> frames;
    if (kept_) frames = kept_->frames();
    finish_playback(*live_, watch_, source_, std::move(frames), options_, callbacks_, playback);
    return playback;
  }

 private:
  // Ends the stream where its input fails, and keeps what came before.
  FrameSource::Received received() {
    try {
      return from_.receive(kLook);
    } catch (const InputError& error) {
      if (!live_) throw;
      warn(std::string(error.what()) + ": what came before stays");
      ended_ = true;
      return {};
    }
  }

  void take(const FrameSource::Received& received) {
    if (received.opened) reader_ = MessageReader();
    try {
      reader_.add(received.bytes);
      while (!ended_) {
        std::optional<LiveMessage> message = reader_.next();
        if (!message) break;
        std::visit([this](auto& content) { handle(std::move(content)); }, *message);
      }
    } catch (const InputError& error) {
      warn(from_.sender() + "'s " + error.what() + ": no more of it is taken, what came before stays");
      from_.hang_up();
      reader_ = MessageReader();
    }
    if (received.stalled) {
      warn("the client has sent nothing for a while, and another one waits: its connection is ended");
    } else if (received.closed && !ended_) {
      warn("the client has gone without an end message; another may come");
    }
    if (received.ended && !ended_) {
      if (reader_.has_more()) warn("the input ends in the middle of a message; what came before stays");
      ended_ = true;
    }
  }

  void handle(FrameMessage&& message) {
    if (!names_.insert(message.name).second) throw InputError("frame " + message.name + " came before");
    if (has_pieces_ && !message.depth.empty()) {
      throw InputError("frame " + message.name + " has depths, and the surface of this stream is made of pieces");
    }
    if (!live_) start(message.camera.center());
    ++record_.frames;
    keep(message);
    move(message.camera);
    const auto frame = std::make_shared<const FrameMessage>(std::move(message));
    has_depths_ = has_depths_ || !frame->depth.empty();
    if (!frame->depth.empty()) live_->fuse(frame->name, frame->camera, [frame] { return depth_of(*frame); });
    if (frame->photograph.empty()) return;
    source_.offered.push_back(frame->name);
    const Clock::time_point called = Clock::now();
    (void)live_->offer(frame->name, frame->camera, [frame] { return read_photograph(frame->photograph, frame->name); });
    record_.offer_ms.push_back(ms_since(called));
  }

  void handle(MovesMessage&& message) {
    if (!live_) return;
    if (kept_) kept_->move(message.views);
    for (MovedView& view : message.views) move(view.camera);
    live_->move_views(message.views);
  }

  void handle(PieceMessage&& message) {
    if (has_depths_) {
      throw InputError("piece of surface comes after frames with depths, of which the surface of this stream is made");
    }
    TriangleSoup& piece = message.surface;
    if (!live_ && piece.faces.empty()) return;
    has_pieces_ = true;
    if (!live_) start(piece.positions[piece.faces.front().x]);
    for (glm::dvec3& position : piece.positions) position -= options_.live.surface.offset;
    if (!live_->replace_piece(message.id, std::move(piece)) && !told_of_room_) {
      told_of_room_ = true;
      warn("piece " + std::to_string(message.id) + " of the surface finds no room: " + live_->status().last_failure);
    }
  }

  void handle(EndMessage&& /*end*/) { ended_ = true; }

  // Keeps the frame for the end of the stream. A disk that refuses does not end the stream.
  void keep(const FrameMessage& message) {
    if (!kept_) return;
    try {
      kept_->keep(message);
    } catch (const InputError& error) {
      warn(std::string(error.what()) + "; the model is saved as the stream leaves it");
      kept_.reset();
    }
  }

  // `near`: a point of the scene, in the stream's own coordinates.
  void start(const glm::dvec3& near) {
    if (options_.finish) kept_.emplace(scratch_folder_of(options_), options_.kept_bytes);
    options_.live.surface.offset = glm::round(near);
    options_.live.surface.scratch_folder = options_.scratch_folder;
    live_ = std::make_unique<LiveModel>(options_.live);
    if (callbacks_.watch) watch_ = callbacks_.watch(*live_);
    start_ = Clock::now();
  }

  void move(Camera& camera) const {
    camera.cam_from_world_translation += camera.cam_from_world_rotation * options_.live.surface.offset;
  }

  [[nodiscard]] double seconds() const {
    return live_ ? std::chrono::duration<double>(Clock::now() - start_).count() : 0;
  }

  void tell() {
    next_tell_ = Clock::now() + kTell;
    if (!live_) return;
    const LiveStatus status = live_->status();
    note_moment(seconds(), status, offers_told_, record_);
    if (status.surface_failure != told_failure_) {
      told_failure_ = status.surface_failure;
      if (!told_failure_.empty()) warn("the surface stays as it was: " + told_failure_);
    }
    if (callbacks_.told) callbacks_.told({seconds(), 0, record_.frames, 0, status});
  }

  void warn(const std::string& sentence) const {
    if (callbacks_.warned) callbacks_.warned(sentence);
  }

  FrameSource& from_;
  PlaybackOptions& options_;
  const PlaybackCallbacks& callbacks_;
  MessageReader reader_;
  std::set<std::string> names_;
  PlayedSource source_;
  PlaybackRecord record_;
  std::unique_ptr<LiveModel> live_;
  std::optional<KeptFrames> kept_;
  std::shared_ptr<void> watch_;
  Clock::time_point start_, next_tell_ = Clock::now() + kTell;
  bool ended_ = false;
  bool has_depths_ = false, has_pieces_ = false;  // of the two, a stream has one
  bool told_of_room_ = false;                     // that a piece found none
  std::string told_failure_;                      // of the surface
  std::size_t offers_told_ = 0;
};

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
  PlayedSource source{stream.scene, {}};
  for (std::size_t i = 0; i < record.frames; ++i) {
    if (stream.frames[i].view) source.offered.push_back(stream.scene.views[*stream.frames[i].view].name);
  }
  std::optional<StreamedFrames> frames;
  if (options.finish) frames = played_frames(stream, record.frames);
  finish_playback(live, watch, source, std::move(frames), options, callbacks, playback);
  playback.result.total_ms = ms_since(start);
  return playback;
}

Playback receive_stream(FrameSource& source, PlaybackOptions options, const PlaybackCallbacks& callbacks) {
  check(options);
  const Clock::time_point start = Clock::now();
  Receiver receiver(source, options, callbacks);
  Playback playback = receiver.receive();
  playback.result.total_ms = ms_since(start);
  return playback;
}

}  // namespace lumatlas
