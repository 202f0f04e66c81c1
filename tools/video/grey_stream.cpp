// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/video/grey_stream.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include "mesh/base/errors.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

// The head of a PGM picture: "P5", width, height, largest value, and one blank, with blanks between them.
struct PgmHead {
  std::size_t bytes = 0;
  std::uint32_t width = 0, height = 0;
};

[[noreturn]] void refuse() {
  throw InputError("frame of a video: what ffmpeg writes is no PGM picture");
}

// Returns nothing while the head is not whole. Throws InputError for another one.
std::optional<PgmHead> pgm_head(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kLongest = 64;
  constexpr std::uint32_t kLargest = 1 << 16;
  PgmHead head{2, 0, 0};
  std::uint32_t levels = 0;
  if (bytes.size() < 2) return std::nullopt;
  if (bytes[0] != 'P' || bytes[1] != '5') refuse();
  for (std::uint32_t* const value : {&head.width, &head.height, &levels}) {
    while (head.bytes < bytes.size() && std::isspace(bytes[head.bytes]) != 0) ++head.bytes;
    for (; head.bytes < bytes.size() && std::isdigit(bytes[head.bytes]) != 0; ++head.bytes) {
      *value = *value * 10 + (bytes[head.bytes] - '0');
      if (*value > kLargest) refuse();
    }
    if (head.bytes == bytes.size()) {
      if (bytes.size() > kLongest) refuse();
      return std::nullopt;
    }
  }
  if (head.width == 0 || head.height == 0 || levels != 255 || std::isspace(bytes[head.bytes]) == 0) refuse();
  ++head.bytes;
  return head;
}

}  // namespace

GreyStream::GreyStream(fs::path path, const Look& look) : path_(std::move(path)), look_(look) {
  constexpr int kPipeBytes = 1 << 20;
  std::error_code ignored;
  fs::remove(path_, ignored);
  if (mkfifo(path_.c_str(), 0600) != 0 || (file_ = open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) < 0) {
    const std::string reason = std::strerror(errno);
    fs::remove(path_, ignored);
    throw InputError(path_.string() + ": no pipe can be made (" + reason + ")");
  }
  (void)fcntl(file_, F_SETPIPE_SZ, kPipeBytes);  // larger is only faster
}

GreyStream::~GreyStream() {
  close(file_);
  std::error_code ignored;
  fs::remove(path_, ignored);
}

void GreyStream::read() {
  constexpr std::size_t kAtOnce = 1 << 16;
  while (true) {
    const std::size_t before = bytes_.size();
    bytes_.resize(before + kAtOnce);
    const ssize_t count = ::read(file_, bytes_.data() + before, kAtOnce);
    const int error = errno;
    bytes_.resize(before + static_cast<std::size_t>(count > 0 ? count : 0));
    while (look_at_one()) continue;
    if (count == 0 || (count < 0 && error != EINTR)) return;
  }
}

bool GreyStream::look_at_one() {
  const std::optional<PgmHead> head = pgm_head(bytes_);
  if (!head) return false;
  const std::size_t pixels = std::size_t{head->width} * head->height, whole = head->bytes + pixels;
  if (bytes_.size() < whole) return false;
  look_(std::span(bytes_).subspan(head->bytes, pixels), head->width, head->height);
  ++frames_;
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(whole));
  return true;
}

}  // namespace lumatlas
