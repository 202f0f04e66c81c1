// SPDX-License-Identifier: GPL-3.0-or-later
// A client of receive_stream() that may send anything.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/tools/live/playback/stream_bytes.h"
#include "tests/tools/live/room_stream.h"

namespace lumatlas {

// Connects to a receiver. The destructor closes the connection, whatever was sent.
class StreamClient {
 public:
  explicit StreamClient(std::uint16_t port) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
  }
  ~StreamClient() { close(socket_); }
  StreamClient(const StreamClient&) = delete;
  StreamClient& operator=(const StreamClient&) = delete;

  void send_all(const StreamBytes& bytes) const {
    for (std::size_t at = 0; at < bytes.size();) {
      const ssize_t sent = send(socket_, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
      if (sent <= 0) return;  // the other end has hung up
      at += static_cast<std::size_t>(sent);
    }
  }

 private:
  int socket_;
};

// A frame of the room's walk, under the room's name of it or another one.
[[nodiscard]] inline StreamBytes room_frame(std::size_t number, const std::string& name = {}) {
  const Camera camera = room_camera(number);
  const DepthImage image = room_depth(camera);
  std::vector<std::uint16_t> depth;
  for (const float value : image.depth) depth.push_back(static_cast<std::uint16_t>(value * 5000 + 0.5F));
  return frame_bytes(name.empty() ? room_view(number) + ".png" : name, camera,
                     encode_image(pattern_photograph(camera, number), {}), depth, 1.0 / 5000);
}

// The same without depths.
[[nodiscard]] inline StreamBytes room_photograph(std::size_t number, const std::string& name = {}) {
  const Camera camera = room_camera(number);
  return frame_bytes(name.empty() ? room_view(number) + ".png" : name, camera,
                     encode_image(pattern_photograph(camera, number), {}), {}, 0);
}

[[nodiscard]] inline StreamBytes room_opening() {
  StreamBytes bytes = greeting_bytes();
  append(bytes, lens_bytes(room_camera(0)));
  return bytes;
}

}  // namespace lumatlas
