// SPDX-License-Identifier: GPL-3.0-or-later
// Sources of a stream's bytes: FrameSocket and FrameInput.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace lumatlas {

class FrameSource {
 public:
  FrameSource() = default;
  virtual ~FrameSource() = default;
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;

  struct Received {
    std::vector<std::uint8_t> bytes;      // in the order in which they were sent; empty: none came
    bool opened = false, closed = false;  // a sender came before these bytes, went after them
    bool stalled = false;                 // the sender that is closed was silent while another one waited
    bool ended = false;                   // no more bytes will come from any sender
  };
  // Waits for bytes for at most that time. Throws InputError if bytes cannot be read.
  [[nodiscard]] virtual Received receive(std::chrono::milliseconds patience) = 0;
  // Takes no more bytes of the sender that is there.
  virtual void hang_up() = 0;
  // Names a sender in messages.
  [[nodiscard]] virtual std::string sender() const = 0;
};

}  // namespace lumatlas
