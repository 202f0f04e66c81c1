// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/playback/frame_socket.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <system_error>

#include "mesh/base/errors.h"

namespace lumatlas {

namespace {

constexpr std::size_t kAtOnce = std::size_t{1} << 20U;  // bytes

// Waits at most that long for bytes of a client, or for a client at a listener.
bool can_read(int descriptor, std::chrono::milliseconds patience) {
  pollfd waits{descriptor, POLLIN, 0};
  return poll(&waits, 1, static_cast<int>(patience.count())) > 0;
}

[[noreturn]] void refuse_port(std::uint16_t port) {
  throw InputError("port " + std::to_string(port) +
                   " of 127.0.0.1 cannot be listened at: " + std::generic_category().message(errno));
}

}  // namespace

FrameSocket::FrameSocket(std::uint16_t port, std::chrono::milliseconds most_silence)
    : listener_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)), most_silence_(most_silence) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  const int yes = 1;
  if (listener_ < 0 || setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
      bind(listener_, generic, size) != 0 || listen(listener_, 1) != 0 || getsockname(listener_, generic, &size) != 0) {
    const int error = errno;
    if (listener_ >= 0) close(listener_);
    errno = error;
    refuse_port(port);
  }
  port_ = ntohs(address.sin_port);
}

FrameSocket::~FrameSocket() {
  FrameSocket::hang_up();
  close(listener_);
}

void FrameSocket::hang_up() {
  if (client_ >= 0) close(client_);
  client_ = -1;
}

FrameSource::Received FrameSocket::receive(std::chrono::milliseconds patience) {
  Received received;
  if (client_ < 0) {
    if (!can_read(listener_, patience)) return received;
    client_ = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    received.opened = client_ >= 0;
    heard_ = std::chrono::steady_clock::now();
    return received;
  }
  if (!can_read(client_, patience)) {
    const bool is_silent = std::chrono::steady_clock::now() - heard_ > most_silence_;
    if (is_silent && can_read(listener_, std::chrono::milliseconds(0))) {
      received.closed = received.stalled = true;
      hang_up();
    }
    return received;
  }
  heard_ = std::chrono::steady_clock::now();
  received.bytes.resize(kAtOnce);
  const ssize_t count = recv(client_, received.bytes.data(), received.bytes.size(), MSG_DONTWAIT);
  const bool waits_on = count < 0 && (errno == EAGAIN || errno == EINTR);
  received.bytes.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
  if (count > 0 || waits_on) return received;
  received.closed = true;
  hang_up();
  return received;
}

}  // namespace lumatlas
