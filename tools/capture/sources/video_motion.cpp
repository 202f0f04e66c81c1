// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/sources/video_motion.h"

#include <nlohmann/json.hpp>
#include <optional>

#include "mesh/base/errors.h"
#include "tools/base/output_folder.h"
#include "tools/base/process/interrupt.h"
#include "tools/base/strict_json.h"
#include "tools/capture/step_record.h"
#include "tools/video/frame_motion.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::uint32_t kMeasuredSide = 640;  // pixels: motion blur is still seen, and following corners is quick
constexpr std::size_t kNumbers = 2 + 2 * kFlowParts;

json frame_json(const VideoFrame& frame) {
  json numbers{frame.sharpness, frame.found_again};
  for (const glm::vec2& flow : frame.flow) {
    numbers.push_back(flow.x);
    numbers.push_back(flow.y);
  }
  return numbers;
}

VideoFrame frame_of(const json& numbers) {
  VideoFrame frame{numbers.at(0), numbers.at(1), {}};
  for (std::size_t part = 0; part < kFlowParts; ++part) {
    frame.flow[part] = {numbers.at(2 + 2 * part), numbers.at(3 + 2 * part)};
  }
  return frame;
}

// Returns what was kept for the file in this state; nothing where that is another file's, or not what write_motion()
// writes.
std::optional<VideoMotion> read_motion(const fs::path& kept, const json& state) {
  std::error_code ignored;
  if (!fs::exists(kept, ignored)) return std::nullopt;
  try {
    const json read = read_json(kept);
    if (read.at("file") != state || read.at("side") != kMeasuredSide) return std::nullopt;
    VideoMotion motion{{}, read.at("damage")};
    for (const json& numbers : read.at("frames")) {
      if (numbers.size() != kNumbers) return std::nullopt;
      motion.frames.push_back(frame_of(numbers));
    }
    return motion;
  } catch (const InputError&) {
    return std::nullopt;
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

void write_motion(const fs::path& kept, const json& state, const VideoMotion& motion) {
  json frames = json::array();
  for (const VideoFrame& frame : motion.frames) frames.push_back(frame_json(frame));
  // The output of another program need not be UTF-8.
  const std::string damage = is_utf8(motion.damage) ? motion.damage : "damage";
  write_json(kept, {{"file", state}, {"side", kMeasuredSide}, {"damage", damage}, {"frames", std::move(frames)}});
}

}  // namespace

VideoMotion motion_of(const VideoFile& video, const fs::path& file, const fs::path& kept, const StageProgress& stage) {
  const json state = file_state(file);
  if (std::optional<VideoMotion> motion = read_motion(kept, state)) return std::move(*motion);
  VideoMotion motion;
  FrameMotion meter;
  const std::size_t expected = video.facts().frames;
  const auto tick =
      stage ? stage("frames of " + file.filename().string(), expected) : std::function<void(std::size_t)>();
  video.for_each_grey_frame(kMeasuredSide,
                            [&](std::span<const std::uint8_t> grey, std::uint32_t width, std::uint32_t height) {
                              throw_if_interrupted();
                              motion.frames.push_back(meter.next(grey, width, height));
                              if (tick && motion.frames.size() <= expected) tick(1);
                            });
  motion.damage = video.damage();
  write_motion(kept, state, motion);
  return motion;
}

}  // namespace lumatlas
