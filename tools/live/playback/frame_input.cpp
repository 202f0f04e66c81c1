// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/playback/frame_input.h"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <system_error>

#include "mesh/base/errors.h"

namespace lumatlas {

FrameSource::Received FrameInput::receive(std::chrono::milliseconds patience) {
  constexpr std::size_t kAtOnce = std::size_t{1} << 20U;  // bytes
  Received received;
  received.ended = ended_;
  if (ended_) return received;
  pollfd waits{descriptor_, POLLIN, 0};
  const int ready = poll(&waits, 1, static_cast<int>(patience.count()));
  if (ready < 0 && errno != EINTR) {
    throw InputError("the input cannot be waited for: " + std::generic_category().message(errno));
  }
  if (ready <= 0) return received;
  received.bytes.resize(kAtOnce);
  const ssize_t count = read(descriptor_, received.bytes.data(), received.bytes.size());
  const int error = errno;
  received.bytes.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
  if (count < 0 && error != EAGAIN && error != EINTR) {
    throw InputError("the input cannot be read: " + std::generic_category().message(error));
  }
  received.ended = ended_ = count == 0;
  return received;
}

}  // namespace lumatlas
