// SPDX-License-Identifier: GPL-3.0-or-later
// Feeds a LiveModel with a capture, which is played at the pace at which it was taken, or with the frames that another
// program sends.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/base/progress.h"
#include "tools/live/live_model.h"
#include "tools/live/playback/frame_source.h"
#include "tools/pipeline/build_model.h"
#include "tools/scene/scene.h"

namespace lumatlas {

struct PlaybackOptions {
  LiveOptions live;
  PictureFolders pictures;
  std::optional<HoldOut> hold_out;  // photographs that are not offered; their depth images are fused
  double speed = 1;                 // times as fast as it was taken, finite, > 0
  double rate = 10;                 // photographs a second where the capture has no times, finite, > 0
  std::uint32_t polish_steps = 0;   // see LiveModel::finish()
  bool measure_deviation = true;    // see BuildOptions::measure_deviation
  // Makes the model anew, at rest, when the stream has ended: see finished_model.h. A client's frames are kept for it
  // in files in `scratch_folder`, of at most `kept_bytes`; empty: the system's folder for temporary files.
  bool finish = true;
  std::filesystem::path scratch_folder;
  std::uint64_t kept_bytes = std::uint64_t{8} << 30U;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const PlaybackOptions& options);

// Tells how far the stream has come.
struct PlaybackProgress {
  double time = 0, seconds = 0;       // of the stream: now, and its last frame's; 0: not known
  std::size_t frame = 0, frames = 0;  // those that came, and all; 0: not known
  LiveStatus live;
};

struct PlaybackCallbacks {
  std::function<bool()> ended;                             // asked some times a second; true ends the stream
  std::function<void(const PlaybackProgress&)> told;       // about once a second, and when the stream has ended
  std::function<void(const std::string&)> warned;          // sentences about a client of receive_stream()
  std::function<std::shared_ptr<void>(LiveModel&)> watch;  // as AtlasWatch
  // Called with the number of depth images and photographs when the model is about to be made anew. What the two after
  // it show is that work's progress; where one of them throws BuildStopped, the model stays as the stream left it.
  std::function<void(std::size_t depths, std::size_t photographs)> finishing;
  StageProgress fusing;
  BuildCallback building;
};

// Tells how the stream stood at a moment. One is noted about once a second.
struct PlaybackMoment {
  double seconds = 0;                                // wall time since the stream began
  std::size_t frames = 0;                            // that came until then
  double offer_median_ms = 0, offer_worst_ms = 0;    // of the calls of offer() since the moment before; 0: none
  std::uint64_t depths_given = 0, depths_fused = 0;  // until then
  std::uint32_t held = 0, waiting = 0;               // photographs
  std::uint64_t faces = 0;
  double summed_coverage = 0;        // see LiveStatus
  std::uint64_t resident_bytes = 0;  // of the process
};

// Records how the model was made anew when the stream had ended.
struct FinishRecord {
  bool done = false;    // false: the model is as the stream left it
  std::string why_not;  // a sentence, where it was asked for and could not be
  double voxel = 0;     // see FinishedModel
  double fusing_ms = 0, building_ms = 0;
};

// Records the times of the calls of the stream, and the outcomes of its views.
struct PlaybackRecord {
  std::size_t frames = 0;        // that were played
  double seconds = 0;            // wall time of the stream
  double finish_ms = 0;          // wall time from its end to the result
  std::vector<double> offer_ms;  // each call of offer(), until it returned
  std::vector<PlaybackMoment> moments;
  std::vector<double> late_ms;        // how much later than it should each frame was played
  std::vector<LiveOutcome> outcomes;  // while the stream ran
  LiveStatus live;
  FinishRecord finish;
  bool ended_early = false;
};

struct Playback {
  BuildResult result;  // as save_model() takes it
  PlaybackRecord record;
};

// Throws InputError, what check() throws, and what the callbacks throw. Where no view was stored, the result holds
// none, and save_model() refuses it.
[[nodiscard]] Playback play_capture(const std::filesystem::path& folder, PlaybackOptions options,
                                    const PlaybackCallbacks& callbacks = {});

// Takes the frames that programs send (tools/live/README.md), until one of them ends the stream, the source ends, or
// `ended` says so. A client of a socket that goes, stalls or sends nonsense ends nothing: what it sent before stays,
// and another one may come. Throws as play_capture(), and InputError where no frame came.
[[nodiscard]] Playback receive_stream(FrameSource& source, PlaybackOptions options,
                                      const PlaybackCallbacks& callbacks = {});

}  // namespace lumatlas
