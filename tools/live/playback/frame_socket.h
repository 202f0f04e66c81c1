// SPDX-License-Identifier: GPL-3.0-or-later
// A port of the loopback address at which one program at a time sends bytes.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace lumatlas {

class FrameSocket {
 public:
  // Listens. 0: any port that is free. Throws InputError if the port cannot be opened.
  explicit FrameSocket(std::uint16_t port);
  ~FrameSocket();
  FrameSocket(const FrameSocket&) = delete;
  FrameSocket& operator=(const FrameSocket&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }

  struct Received {
    std::vector<std::uint8_t> bytes;      // in the order in which they were sent; empty: none came
    bool opened = false, closed = false;  // a client came before these bytes, went after them
  };
  // Waits for bytes for at most that time. While a client is there, others wait.
  [[nodiscard]] Received receive(std::chrono::milliseconds patience);
  // Ends the connection of the client that is there.
  void hang_up();

 private:
  int listener_ = -1, client_ = -1;
  std::uint16_t port_ = 0;
};

}  // namespace lumatlas
