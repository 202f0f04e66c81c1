// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps the frames that a client sent, in files, for the model that is made of them when the stream has ended. They
// take a bounded number of bytes: when they would take more, every second frame is given up, and from then on every
// second one of those that come is kept.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "mesh/base/temporary_entry.h"
#include "tools/live/live_model.h"
#include "tools/live/playback/finished_model.h"
#include "tools/live/playback/frame_message.h"

namespace lumatlas {

class KeptFrames {
 public:
  // Makes a temporary folder in `folder`, which goes with this object. Throws InputError where that cannot be.
  KeptFrames(const std::filesystem::path& folder, std::uint64_t most_bytes);

  // Writes a frame's files. The camera is in the stream's own coordinates. Throws InputError where the disk refuses.
  void keep(const FrameMessage& message);
  // Gives frames other poses, by name.
  void move(const std::vector<MovedView>& views);

  // Returns the frames that are kept; their files last as long as this.
  [[nodiscard]] StreamedFrames frames() const;
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  struct Frame {
    std::string name;
    Camera camera;
    std::filesystem::path photograph, depth;  // empty: it has none
    double depth_unit = 0;
    std::uint64_t bytes = 0;
  };

  void write(const std::filesystem::path& file, const std::vector<std::uint8_t>& bytes, Frame& frame) const;
  void thin();

  TemporaryEntry folder_;
  std::uint64_t most_bytes_;
  std::vector<Frame> frames_;  // those kept, in the order in which they came
  std::uint64_t bytes_ = 0;
  std::size_t every_ = 1;  // a power of two: this many frames come for each that is kept
  std::size_t came_ = 0;
};

}  // namespace lumatlas
