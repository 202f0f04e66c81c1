// SPDX-License-Identifier: GPL-3.0-or-later
// A pipe or file from which the bytes of a stream are read, such as standard input. Its end ends the stream.
#pragma once

#include "tools/live/playback/frame_source.h"

namespace lumatlas {

class FrameInput : public FrameSource {
 public:
  // `descriptor` is open for reading, and stays the caller's.
  explicit FrameInput(int descriptor) : descriptor_(descriptor) {}

  [[nodiscard]] Received receive(std::chrono::milliseconds patience) override;
  void hang_up() override { ended_ = true; }
  [[nodiscard]] std::string sender() const override { return "the input"; }

 private:
  int descriptor_;
  bool ended_ = false;
};

}  // namespace lumatlas
