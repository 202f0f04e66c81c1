// SPDX-License-Identifier: GPL-3.0-or-later
// A port of the loopback address at which one program at a time sends bytes.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "tools/live/playback/frame_source.h"

namespace lumatlas {

class FrameSocket : public FrameSource {
 public:
  // Listens. 0: any port that is free. A client that has sent nothing for `most_silence` gives way to one that waits.
  // Throws InputError if the port cannot be opened.
  explicit FrameSocket(std::uint16_t port, std::chrono::milliseconds most_silence = std::chrono::seconds(10));
  ~FrameSocket() override;

  [[nodiscard]] std::uint16_t port() const { return port_; }

  // While a client is there, others wait.
  [[nodiscard]] Received receive(std::chrono::milliseconds patience) override;
  // Ends the connection of the client that is there.
  void hang_up() override;
  [[nodiscard]] std::string sender() const override { return "the client"; }

 private:
  int listener_ = -1, client_ = -1;
  std::chrono::milliseconds most_silence_;
  std::chrono::steady_clock::time_point heard_{};  // when the client sent something last, or came
  std::uint16_t port_ = 0;
};

}  // namespace lumatlas
