// SPDX-License-Identifier: GPL-3.0-or-later
// Measures how sharp the frames of a video are and how their content moves, by OpenCV: corners are followed from each
// frame to the next one (Lucas and Kanade's method on a pyramid, asked in both directions).
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "tools/video/video_frame.h"

namespace lumatlas {

class FrameMotion {
 public:
  FrameMotion();
  ~FrameMotion();
  FrameMotion(const FrameMotion&) = delete;
  FrameMotion& operator=(const FrameMotion&) = delete;

  // Takes the next frame of the video: width * height grey values, row by row from the top left. The first one, and one
  // of another size than the frame before, moves by nothing; of the latter nothing is found again. Throws
  // std::invalid_argument for a size that is 0 or that the span does not have.
  [[nodiscard]] VideoFrame next(std::span<const std::uint8_t> grey, std::uint32_t width, std::uint32_t height);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lumatlas
