// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/ffmpeg_pipe.h"

#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "tools/base/process/child_process.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

std::string text_of(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9g", value);
  return text.data();
}

// A relative name could begin with what ffmpeg takes for an option or a protocol.
std::vector<std::string> arguments(const fs::path& file, std::uint32_t width, std::uint32_t height,
                                   double frames_per_second) {
  return {"-hide_banner",
          "-nostdin",
          "-loglevel",
          "error",
          "-y",
          "-f",
          "rawvideo",
          "-pixel_format",
          "rgb24",
          "-video_size",
          size_text(width, height),
          "-framerate",
          text_of(frames_per_second),
          "-i",
          "pipe:0",
          "-vf",
          "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv",
          "-c:v",
          "libx264",
          "-crf",
          "16",
          "-pix_fmt",
          "yuv420p",
          "-colorspace",
          "bt709",
          "-color_primaries",
          "bt709",
          "-color_trc",
          "iec61966-2-1",
          "-color_range",
          "tv",
          "-movflags",
          "+faststart",
          "file:" + fs::absolute(file).string()};
}

}  // namespace

fs::path find_ffmpeg() {
  if (fs::path program = find_program("ffmpeg"); !program.empty()) return program;
  throw InputError("ffmpeg: PATH has no such program, which videos need: install it, or write pictures (--format png)");
}

FfmpegPipe::FfmpegPipe(const fs::path& ffmpeg, const fs::path& file, std::uint32_t width, std::uint32_t height,
                       double frames_per_second)
    : file_(file), width_(width), height_(height), log_(std::tmpfile()) {
  if (width < 1 || height < 1) throw std::invalid_argument("video: its size must be at least 1x1");
  if (!(std::isfinite(frames_per_second) && frames_per_second > 0)) {
    throw std::invalid_argument("video: frames_per_second is " + std::to_string(frames_per_second) +
                                ", must be finite and positive");
  }
  // A pair of sockets and not a pipe: writing to one whose reader has gone can be asked for without a signal.
  std::array<int, 2> ends{};
  if (!log_ || socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw InputError(file.string() + ": cannot be written, no pipe to ffmpeg: " + std::strerror(errno));
  }
  input_ = ends[0];
  try {
    child_ = start_program(ffmpeg, arguments(file, width, height, frames_per_second),
                           {.in = ends[1], .err = fileno(log_.get())});
  } catch (...) {
    for (const int end : ends) close(end);
    throw;
  }
  close(ends[1]);
}

FfmpegPipe::~FfmpegPipe() {
  if (child_ <= 0) return;
  kill(child_, SIGKILL);
  wait();
}

int FfmpegPipe::wait() {
  close(input_);
  int status = 0;
  while (waitpid(child_, &status, 0) < 0 && errno == EINTR) {
  }
  child_ = -1;
  return status;
}

// Waits for ffmpeg, so that its log is complete.
void FfmpegPipe::fail(const std::string& what) {
  if (child_ > 0) wait();
  std::rewind(log_.get());
  std::string last;
  std::array<char, 1024> line{};
  while (std::fgets(line.data(), static_cast<int>(line.size()), log_.get()) != nullptr) {
    std::string_view text(line.data());
    while (!text.empty() && std::strchr(" \r\n", text.back()) != nullptr) text.remove_suffix(1);
    if (!text.empty()) last = text;
  }
  throw InputError(file_.string() + ": " + what + (last.empty() ? "" : " (" + last + ")"));
}

void FfmpegPipe::write(const Photograph& frame) {
  if (frame.width != width_ || frame.height != height_) {
    throw std::invalid_argument("video: a frame is " + size_text(frame.width, frame.height) + ", must be " +
                                std::to_string(width_) + "x" + std::to_string(height_) + " as the first");
  }
  const char* bytes = reinterpret_cast<const char*>(frame.rgb.data());
  for (std::size_t left = frame.rgb.size(); left > 0;) {
    const ssize_t sent = send(input_, bytes, left, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) fail("ffmpeg takes no more frames");
    bytes += sent;
    left -= static_cast<std::size_t>(sent);
  }
}

void FfmpegPipe::finish() {
  const int status = wait();
  if (WIFSIGNALED(status)) fail("ffmpeg was ended by signal " + std::to_string(WTERMSIG(status)));
  if (WEXITSTATUS(status) != 0) fail("ffmpeg has failed with exit status " + std::to_string(WEXITSTATUS(status)));
  std::error_code ignored;
  if (!fs::is_regular_file(file_, ignored)) fail("ffmpeg has written no file");
}

}  // namespace lumatlas
